#include "nlg/shader_grid.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "runtime_eval/evaluator/dictionary.h"
#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/light_grid/packed_light.h"
#include "runtime_eval/probe_tree/probe_tree_data.h"
#include "runtime_eval/weights_file/sha256.h"

namespace nlg {
namespace {

// look_up.glsl's
enum Kind : uint32_t { kNone, kTent, kNetwork4, kNetwork44, kNetwork88, kField, kBrick };
constexpr uint32_t kTentFlag = 8, kSigmoidFlag = 16, kHalvesFlag = 32;
constexpr int kClassHeader = 5, kHeadersAClass = 2, kHeadersAnAxis = 7;
constexpr size_t kDigestWord = 14, kDigestWords = 2;
constexpr uint32_t kNoBlock = 0xffffffffu, kIndexMask = (1u << 27) - 1, kUsed = 1u << 31;
constexpr int kBlockLog2 = 2, kBlockSide = 1 << kBlockLog2;
constexpr size_t kWordsAFour = 4;
constexpr uint64_t kMostWords = 1ull << 29;
constexpr int kBrickBits = 27, kMostExponent = 31 + kLeastStepExponent;  // of a record's word that names a brick; of a step
constexpr uint32_t kNoBrick = 0xffffffffu;
static_assert(quadCount(3) % 4 == 0 && quadCount(5) % 4 == 0 && quadCount(7) % 4 == 0 && quadCount(9) % 4 == 0,
              "bricks begin at words that records name");

FileResult refuse(std::string detail) { return {FileStatus::value_out_of_range, std::move(detail)}; }

size_t toFours(size_t words) { return (words + kWordsAFour - 1) / kWordsAFour * kWordsAFour; }

uint32_t bitsOf(float value) { return std::bit_cast<uint32_t>(value); }

uint32_t pairOf(Half low, Half high) { return low.bits | uint32_t{high.bits} << 16; }

// Words that look_up.glsl reads of a probe's function: of a field eight nodes, of a brick its name and a cell, of networks whole fours.
size_t readOf(const Representation& representation, size_t theta_words) {
  return representation.isField() ? 8 : representation.isCode() ? 3 : toFours(theta_words);
}

// Probes whose records look alike.
struct ProbeClass {
  uint32_t kind = kNone;  // and flags
  Representation representation;
  uint32_t first_probe = 0;
  size_t stride = 0;  // words
  size_t first_record = 0;
};

Kind kindOf(const Representation& representation) {
  if (representation.isField()) return kField;
  if (representation.isCode()) return kBrick;
  const NetworkShape& shape = representation.shape();
  return shape.second == 0 ? kNetwork4 : shape.first == 4 ? kNetwork44 : kNetwork88;
}

const char* defineOf(uint32_t kind) {
  constexpr const char* kDefines[] = {"", "", "NLG_NETWORK_4", "NLG_NETWORK_44", "NLG_NETWORK_88", "NLG_FIELD", "NLG_BRICK"};
  return kDefines[kind & 7];
}

// Whether shaders have code for a network of this shape.
bool isKnown(const Representation& representation) {
  if (!representation.isNetwork()) return true;
  const NetworkShape& shape = representation.shape();
  return (shape.first == 4 && (shape.second == 0 || shape.second == 4)) || (shape.first == 8 && shape.second == 8);
}

// The numbers of a network in the order of records: fours, columns of matrices; -1 is a gap. Hidden layers first.
struct NetworkOrder {
  std::vector<int> hidden, last;
  explicit NetworkOrder(const NetworkShape& shape) {
    for (int input = 0; input < 3; ++input) {
      for (int unit = 0; unit < shape.first; ++unit) hidden.push_back(shape.w1() + 3 * unit + input);
    }
    for (int unit = 0; unit < shape.first; ++unit) hidden.push_back(shape.b1() + unit);
    for (int input = 0; input < shape.first && shape.second > 0; ++input) {
      for (int unit = 0; unit < shape.second; ++unit) hidden.push_back(shape.w2() + shape.first * unit + input);
    }
    for (int unit = 0; unit < shape.second; ++unit) hidden.push_back(shape.b2() + unit);
    for (int unit = 0; unit < shape.last(); ++unit) last.push_back(shape.w3() + unit);
    last.insert(last.end(), {shape.b3(), -1, -1, -1});
  }
};

bool isInBytes(const Representation& representation, const float* theta) {
  std::vector<float> rounded(theta, theta + representation.thetaCount());
  return representation.isNetwork() && roundTheta(representation, ThetaPrecision::int8, rounded.data()) &&
         std::equal(rounded.begin(), rounded.end(), theta);
}

class Packer {
 public:
  explicit Packer(const LightGrid& grid) : grid_(grid) {}

  FileResult pack(ShaderGrid* result) {
    if (grid_.light.empty()) return refuse("a grid without light");
    const ProbeTreeFrame& frame = grid_.tree.frame();
    // shaders hold the corner as floats: its error shifts the whole grid
    if (!(cornerErrorM(frame) <= kMostCornerError * frame.spacing_m))
      return refuse("its corner is so far from the origin that a float is " + std::to_string(cornerErrorM(frame)) +
                    " m off; give --origin-m");
    // in this order: records need the numbers of probes, these the classes, and these the words of light
    packLightOfProbes();
    findClasses();
    for (const ProbeClass& of : classes_) {
      if (!isKnown(of.representation)) return refuse(std::string("no shader for ") + representationName(of.representation));
    }
    numberProbes();
    result->header_count = colourHeader() + static_cast<int>(grid_.groups.size());
    result->first_colour = grid_.groups.empty() ? 0 : colourHeader();
    for (const LightGroup& group : grid_.groups) result->groups.push_back(group.name);
    words_.resize(static_cast<size_t>(result->header_count) * kWordsAFour);
    FileResult packed = addTree(result);
    if (packed.ok()) packed = addRecords(result);
    if (!packed.ok()) return packed;
    writeHeader();
    writeLightHeader();
    writeDigest();
    defines(result);
    result->words = std::move(words_);
    return {};
  }

 private:
  void packLightOfProbes() {
    light_ = packedLightOf(grid_, kLightError);
    group_count_ = std::max<size_t>(1, grid_.groups.size());
    record_words_ = std::max<size_t>(1, static_cast<size_t>(lightWords(light_)));
    light_words_ = (group_count_ - 1) * toFours(record_words_) + record_words_;
    describeFields();
    float largest = 0.0f;
    for (const std::vector<float>* light : lightByGroup(grid_)) {
      for (const float coefficient : *light) largest = std::max(largest, std::abs(coefficient));
    }
    constexpr int kLargestExponent = 9;  // of what stands over the scale
    if (largest > 0.0f) scale_ = std::ldexp(1.0f, std::ilogb(largest) - kLargestExponent);
  }

  int lightHeader() const { return kClassHeader + kHeadersAClass * static_cast<int>(classes_.size()); }

  int colourHeader() const { return lightHeader() + kHeadersAnAxis * static_cast<int>(light_.axes.size()); }

  // Where theta begins in the records of a class. Words
  size_t thetaWord(const ProbeClass& of) const { return of.representation.isCode() ? light_words_ : toFours(light_words_); }

  // A class a representation and form of theta that some probe has, then bare tents, then probes without weight.
  void findClasses() {
    // one theta beyond bytes puts its whole representation into halves
    std::vector<bool> in_bytes(grid_.representations.size(), true);
    for (size_t f = 0; f < grid_.functionCount(); ++f) {
      const uint8_t r = grid_.function_representation[f];
      if (in_bytes[r]) in_bytes[r] = isInBytes(grid_.representations[r], grid_.functionTheta(f));
    }
    std::vector<size_t> class_of_representation(grid_.representations.size(), 0);
    // a representation that no probe has needs no code in the shader
    std::vector<bool> used(grid_.representations.size(), false);
    for (const uint32_t f : grid_.probe_function) {
      if (f < kNoWeight) used[grid_.function_representation[f]] = true;
    }
    for (size_t r = 0; r < grid_.representations.size(); ++r) {
      if (!used[r]) continue;
      const Representation& representation = grid_.representations[r];
      class_of_representation[r] = classes_.size();
      ProbeClass& of = classes_.emplace_back();
      of.representation = representation;
      of.kind = kindOf(representation);
      // pairs of halves of a field, the name of a brick, hidden and last layer of a network
      size_t theta_words = 0;
      if (representation.isField()) {
        theta_words = static_cast<size_t>(representation.thetaCount()) / 2;
      } else if (representation.isCode()) {
        theta_words = 1;
      } else {
        const NetworkShape& shape = representation.shape();
        if (representation.tentFactor()) of.kind |= kTentFlag;
        if (shape.output == OutputFunction::sigmoid) of.kind |= kSigmoidFlag;
        if (!in_bytes[r]) of.kind |= kHalvesFlag;
        const auto hidden = static_cast<size_t>(shape.w3());
        theta_words = (in_bytes[r] ? hidden / 4 : hidden / 2) + static_cast<size_t>(shape.last()) / 2 + 1;
      }
      of.stride = toFours(thetaWord(of) + theta_words);
      largest_read_ = std::max(largest_read_, readOf(representation, theta_words));
    }
    // bare tents are light alone; probes without weight have no record
    classes_.emplace_back().kind = kTent;
    classes_.back().stride = toFours(light_words_);
    classes_.emplace_back().kind = kNone;
    class_of_probe_.reserve(grid_.probe_function.size());
    for (const uint32_t f : grid_.probe_function) {
      class_of_probe_.push_back(static_cast<uint16_t>(f == kFreeSpace ? classes_.size() - 2
                                                      : f == kNoWeight
                                                          ? classes_.size() - 1
                                                          : class_of_representation[grid_.function_representation[f]]));
    }
  }

  // Within a class in the tree's order: neighbours in space are neighbours in memory.
  void numberProbes() {
    uint32_t next = 0;
    number_.resize(class_of_probe_.size());
    for (size_t k = 0; k < classes_.size(); ++k) {
      classes_[k].first_probe = next;
      for (size_t probe = 0; probe < class_of_probe_.size(); ++probe) {
        if (class_of_probe_[probe] == k) number_[probe] = next++;
      }
    }
  }

  FileResult addTree(ShaderGrid* result) {
    const ProbeTreeData tree = probeTreeData(grid_.tree);
    const ProbeTreeLists lists = probeTreeLists(grid_.tree);
    if (lists.slots.size() > kIndexMask) return refuse(std::to_string(lists.slots.size()) + " slots; shaders address 2^27");
    // the box of all blocks that a used cell reaches into
    std::array<int32_t, 3> low{INT32_MAX, INT32_MAX, INT32_MAX}, high{0, 0, 0};
    grid_.tree.forEachCell([&](const ProbeCell& cell) {
      for (size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], cell.low[axis] >> kBlockLog2);
        high[axis] = std::max(high[axis], ((cell.low[axis] + cell.side - 1) >> kBlockLog2) + 1);
      }
    });
    uint64_t count = 1;
    for (size_t axis = 0; axis < 3; ++axis) {
      first_block_[axis] = grid_.tree.cellCount() > 0 ? low[axis] : 0;
      block_count_[axis] = grid_.tree.cellCount() > 0 ? high[axis] - low[axis] : 0;
      count *= static_cast<uint64_t>(block_count_[axis]);
    }
    if (count > kMaxShaderBlocks) return refuse(std::to_string(count) + " blocks of 4³ units; shaders address 2^26");
    // each block of 4³ units names the node whose cells cover it: a shader reads once where the tree takes steps
    first_block_word_ = words_.size();
    words_.resize(words_.size() + toFours(count), kNoBlock);
    first_slot_word_ = words_.size();
    words_.resize(words_.size() + toFours(lists.slots.size()));
    // slots with the shader's own numbers of probes; the high bits keep the log2 of their spacings
    for (size_t i = 0; i < lists.slots.size(); ++i) {
      const uint32_t slot = lists.slots[i];
      if (slot != kNoProbe) words_[first_slot_word_ + i] = number_[slot & kIndexMask] | (slot >> 27) << 27;
    }
    size_t root = 0;
    const std::array<int32_t, 3>& roots = tree.frame.root_count;
    for (int32_t z = 0; z < roots[2]; ++z) {
      for (int32_t y = 0; y < roots[1]; ++y) {
        for (int32_t x = 0; x < roots[0]; ++x) addNode(tree, lists, root++, {x * kRootSide, y * kRootSide, z * kRootSide});
      }
    }
    result->light_read = toFours(light_words_) * sizeof(uint32_t);
    result->largest_read = (toFours(light_words_) + largest_read_) * sizeof(uint32_t);
    result->tree_bytes = (words_.size() - first_block_word_) * sizeof(uint32_t);
    return {};
  }

  // A node's used cells, then its children. low   its corner, units
  void addNode(const ProbeTreeData& tree, const ProbeTreeLists& lists, size_t node, const std::array<int32_t, 3>& low) {
    const uint32_t cells = tree.cell_count[node], edge = cells + 1, cell_log2 = lists.cell_log2[node];
    const auto cornerOf = [&](uint32_t bit) {
      return std::array<int32_t, 3>{low[0] + static_cast<int32_t>((bit & 3) << cell_log2),
                                    low[1] + static_cast<int32_t>((bit >> 2 & 3) << cell_log2),
                                    low[2] + static_cast<int32_t>((bit >> 4) << cell_log2)};
    };
    const auto cells_log2 = static_cast<uint32_t>(std::countr_zero(cells));
    const uint32_t entry = lists.first_slot[node] | cells_log2 << 27 | cell_log2 << 29;
    // a used cell is flagged in the slot of its low corner, and its node entered in all blocks that it covers
    for (uint64_t mask = tree.used_mask[node]; mask != 0; mask &= mask - 1) {
      const auto bit = static_cast<uint32_t>(std::countr_zero(mask));
      words_[first_slot_word_ + lists.first_slot[node] + ((bit >> 4) * edge + (bit >> 2 & 3)) * edge + (bit & 3)] |= kUsed;
      forEachBlock(cornerOf(bit), 1 << cell_log2, [&](size_t block) { words_[first_block_word_ + block] = entry; });
    }
    size_t child = lists.first_child[node];
    for (uint64_t mask = tree.child_mask[node]; mask != 0; mask &= mask - 1)
      addNode(tree, lists, child++, cornerOf(static_cast<uint32_t>(std::countr_zero(mask))));
  }

  template <class Visit>
  void forEachBlock(const std::array<int32_t, 3>& low, int32_t side, const Visit& visit) const {
    std::array<int32_t, 3> begin, end;
    for (size_t axis = 0; axis < 3; ++axis) {
      begin[axis] = (low[axis] >> kBlockLog2) - first_block_[axis];
      end[axis] = begin[axis] + std::max(1, side / kBlockSide);
    }
    for (int32_t z = begin[2]; z < end[2]; ++z) {
      for (int32_t y = begin[1]; y < end[1]; ++y) {
        for (int32_t x = begin[0]; x < end[0]; ++x)
          visit((static_cast<size_t>(z) * block_count_[1] + static_cast<size_t>(y)) * block_count_[0] + static_cast<size_t>(x));
      }
    }
  }

  FileResult addRecords(ShaderGrid* result) {
    // records of a class stand together and have one length: a probe's place is a product
    size_t end = words_.size();
    for (size_t k = 0; k < classes_.size(); ++k) {
      const size_t next = k + 1 < classes_.size() ? classes_[k + 1].first_probe : number_.size();
      classes_[k].first_record = end;
      end += classes_[k].stride * (next - classes_[k].first_probe);
    }
    placeBricks(&end);
    if (end > kMostWords) return refuse(std::to_string(end) + " words; shaders address 2^29");
    words_.resize(end, 0);
    result->probe_record.assign(number_.size(), 0);
    // packed light is of probes with weight alone, group after group
    const auto stored_words = static_cast<size_t>(lightWords(light_));
    const size_t with_weight =
        number_.size() - static_cast<size_t>(std::count(grid_.probe_function.begin(), grid_.probe_function.end(), kNoWeight));
    const uint32_t* light = light_.records.data();
    for (size_t probe = 0; probe < number_.size(); ++probe) {
      const ProbeClass& of = classes_[class_of_probe_[probe]];
      if (of.stride == 0) continue;
      const size_t place = of.first_record + of.stride * (number_[probe] - of.first_probe);
      result->probe_record[probe] = static_cast<uint32_t>(place / kWordsAFour);
      uint32_t* record = &words_[place];
      for (size_t g = 0; g < group_count_; ++g)
        std::copy_n(light + g * with_weight * stored_words, stored_words, record + g * toFours(record_words_));
      light += stored_words;
      result->light_bytes += light_words_ * sizeof(uint32_t);
      const uint32_t function = grid_.probe_function[probe];
      if (function >= kNoWeight) continue;
      if (of.representation.isCode()) {
        // a step is a power of two, whose exponent fits the five bits beside the brick's name
        const int exponent = std::ilogb(grid_.function_brick[function].step);
        if (exponent > kMostExponent)
          return refuse("function " + std::to_string(function) + ": logits beyond the range of shaders");
        record[light_words_] = brick_four_[function] | static_cast<uint32_t>(exponent - kLeastStepExponent) << kBrickBits;
      } else if (!addTheta(of, grid_.functionTheta(function), record + thetaWord(of))) {
        return refuse("function " + std::to_string(function) + ": a number beyond float16");
      }
      result->theta_bytes += (of.stride - light_words_) * sizeof(uint32_t);
    }
    // each brick once, however many probes share its function
    for (size_t function = 0; function < brick_four_.size(); ++function) {
      if (brick_four_[function] == kNoBrick) continue;
      const size_t quads = quadCount(grid_.representations[grid_.function_representation[function]].resolution);
      std::copy_n(grid_.functionQuads(function), quads, &words_[brick_four_[function] * kWordsAFour]);
      result->theta_bytes += quads * sizeof(uint32_t);
    }
    return {};
  }

  // In the order of probes: those that are read together stand together. end   of all words, before and after
  void placeBricks(size_t* end) {
    brick_four_.assign(grid_.functionCount(), kNoBrick);
    for (const uint32_t function : grid_.probe_function) {
      if (function >= kNoWeight || brick_four_[function] != kNoBrick) continue;
      const Representation& representation = grid_.representations[grid_.function_representation[function]];
      if (!representation.isCode()) continue;
      brick_four_[function] = static_cast<uint32_t>(*end / kWordsAFour);
      *end += quadCount(representation.resolution);
    }
  }

  // false: a number is beyond float16
  static bool addTheta(const ProbeClass& of, const float* theta, uint32_t* words) {
    bool fits = true;
    const auto half = [&](int place) {
      Half rounded;
      fits = (place < 0 || halfFromFloat(theta[place], &rounded)) && fits;
      return rounded;
    };
    // nodes are pairs of A and B
    if (of.representation.isField()) {
      for (int node = 0; node < of.representation.thetaCount() / 2; ++node) *words++ = pairOf(half(2 * node), half(2 * node + 1));
      return fits;
    }
    // hidden layers in halves or bytes, the last layer in halves
    const NetworkOrder order(of.representation.shape());
    if (of.kind & kHalvesFlag) {
      for (size_t i = 0; i < order.hidden.size(); i += 2) *words++ = pairOf(half(order.hidden[i]), half(order.hidden[i + 1]));
    } else {
      const float step = stepOf(of.representation.shape());
      for (size_t i = 0; i < order.hidden.size(); ++i) {
        const auto steps = static_cast<uint8_t>(static_cast<int8_t>(theta[order.hidden[i]] / step));
        words[i / 4] |= uint32_t{steps} << 8 * (i % 4);
      }
      words += order.hidden.size() / 4;
    }
    for (size_t i = 0; i + 2 < order.last.size(); i += 2) *words++ = pairOf(half(order.last[i]), half(order.last[i + 1]));
    return fits;
  }

  void writeHeader() {
    const ProbeTreeFrame& frame = grid_.tree.frame();
    const auto write = [&](size_t at, const std::array<uint32_t, 4>& four) {
      std::copy(four.begin(), four.end(), &words_[at * kWordsAFour]);
    };
    const auto metres = [&](size_t axis) { return bitsOf(static_cast<float>(frame.first_m[axis])); };
    // the places that look_up.glsl reads
    write(0, {metres(0), metres(1), metres(2), bitsOf(static_cast<float>(1.0 / frame.spacing_m))});
    const auto blocks = [](const std::array<int32_t, 3>& of, size_t word) {
      return std::array<uint32_t, 4>{static_cast<uint32_t>(of[0]), static_cast<uint32_t>(of[1]), static_cast<uint32_t>(of[2]),
                                     static_cast<uint32_t>(word)};
    };
    write(1, blocks(first_block_, first_block_word_));
    write(2, blocks(block_count_, first_slot_word_));
    write(3, {bitsOf(scale_), static_cast<uint32_t>(classes_.size()), 0, 0});
    write(4, {static_cast<uint32_t>(light_.axes.size()), static_cast<uint32_t>(light_.scale_bits),
              static_cast<uint32_t>(record_words_), static_cast<uint32_t>(grid_.groups.size())});
    for (size_t k = 0; k < classes_.size(); ++k) {
      const ProbeClass& of = classes_[k];
      const bool is_network = (of.kind & 7) > kTent && of.representation.isNetwork();
      write(kClassHeader + kHeadersAClass * k, {of.first_probe, static_cast<uint32_t>(of.first_record / kWordsAFour),
                                                static_cast<uint32_t>(of.stride / kWordsAFour), of.kind});
      write(kClassHeader + kHeadersAClass * k + 1,
            {bitsOf(of.representation.slope), 0, bitsOf(is_network ? stepOf(of.representation.shape()) : 0.0f),
             static_cast<uint32_t>(of.representation.resolution)});
    }
  }

  void writeLightHeader() {
    for (size_t k = 0; k < light_.axes.size(); ++k) {
      const LightAxis& axis = light_.axes[k];
      uint32_t* words = &words_[(static_cast<size_t>(lightHeader()) + kHeadersAnAxis * k) * kWordsAFour];
      for (size_t i = 0; i < kShFloats; ++i) {
        // a channel's eight coefficients of order 1 and 2 side by side, the constants of all channels behind them
        const size_t coefficient = i / kShChannels, channel = i % kShChannels;
        const size_t place = coefficient == 0 ? 24 + channel : 8 * channel + coefficient - 1;
        words[place] = bitsOf(light_.unit / scale_ * floatFromHalf({axis.direction[i]}));
      }
      words[27] = light_fields_[k];
    }
    const std::vector<std::array<float, 3>> colours = startingColours(grid_);
    for (size_t g = 0; g < colours.size(); ++g)
      std::transform(colours[g].begin(), colours[g].end(), &words_[(static_cast<size_t>(colourHeader()) + g) * kWordsAFour],
                     bitsOf);
  }

  void describeFields() {
    const std::vector<LightField> fields = lightFields(light_);
    for (size_t k = 0; k < light_.axes.size(); ++k) {
      const LightField& field = fields[k + 1];
      light_fields_.push_back(static_cast<uint32_t>(field.word) | static_cast<uint32_t>(field.shift) << 3 |
                              static_cast<uint32_t>(field.bits) << 8 | static_cast<uint32_t>(light_.axes[k].offset) << 16);
    }
  }

  // Once everything else stands.
  void writeDigest() {
    Sha256 hash;
    hash.add(words_.data(), words_.size() * sizeof(uint32_t));
    const Sha256Digest digest = hash.finish();
    std::memcpy(&words_[kDigestWord], digest.data(), kDigestWords * sizeof(uint32_t));
  }

  void defines(ShaderGrid* result) const {
    for (const ProbeClass& of : classes_) {
      const std::string define = defineOf(of.kind);
      std::vector<std::string>& all = result->defines;
      if (!define.empty() && std::find(all.begin(), all.end(), define) == all.end()) all.push_back(define);
    }
    if (std::any_of(classes_.begin(), classes_.end(), [](const ProbeClass& of) { return (of.kind & kHalvesFlag) != 0; }))
      result->defines.push_back("NLG_HALVES");
    result->defines.push_back("NLG_CLASS_COUNT " + std::to_string(classes_.size()));
    result->defines.push_back("NLG_LIGHT_AXES " + std::to_string(light_.axes.size()));
    result->defines.push_back("NLG_LIGHT_WORDS " + std::to_string(record_words_));
    if (!grid_.groups.empty()) result->defines.push_back("NLG_LIGHT_GROUPS " + std::to_string(grid_.groups.size()));
    std::string fields;
    for (const uint32_t field : light_fields_) fields += (fields.empty() ? "" : ", ") + std::to_string(field) + 'u';
    if (!fields.empty()) result->defines.push_back("NLG_LIGHT_FIELDS uint[](" + fields + ')');
  }

  const LightGrid& grid_;
  std::vector<ProbeClass> classes_;
  std::vector<uint16_t> class_of_probe_;
  std::vector<uint32_t> number_;      // by probe
  std::vector<uint32_t> brick_four_;  // by function: where its brick begins; kNoBrick of those that no probe has
  std::vector<uint32_t> words_;
  std::array<int32_t, 3> first_block_{}, block_count_{};
  size_t first_block_word_ = 0, first_slot_word_ = 0;
  PackedLight light_;
  std::vector<uint32_t> light_fields_;  // by axis: where its number stands, as shaders read it
  float scale_ = 1.0f;                  // over which the light of all probes fits float16
  size_t group_count_ = 1;
  size_t record_words_ = 1;  // of a record of light; one where nothing is lit
  size_t light_words_ = 1;   // of a probe, all its groups
  size_t largest_read_ = 0;  // words of a function
};

}  // namespace

double cornerErrorM(const ProbeTreeFrame& frame) {
  double error_m = 0.0;
  for (const double at_m : frame.first_m)
    error_m = std::max(error_m, std::abs(static_cast<double>(static_cast<float>(at_m)) - at_m));
  return error_m;
}

FileResult packShaderGrid(const LightGrid& grid, ShaderGrid* shader_grid) {
  *shader_grid = {};
  FileResult result = Packer(grid).pack(shader_grid);
  if (!result.ok()) *shader_grid = {};
  return result;
}

}  // namespace nlg
