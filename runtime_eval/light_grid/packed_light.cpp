// Axes by Jacobi's method; bits by a greedy choice of those that lower the error most.
// Both are tried for many steps of the numbers, and the fewest words that keep the error win.
#include "runtime_eval/light_grid/packed_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

namespace nlg {
namespace {

constexpr int kWordBits = 32;
constexpr size_t kMostSampled = 16384;  // probes that the layout is chosen by
constexpr double kDark = 0x1p-40;       // of the brightest probe
constexpr double kDarkest = 1e-30;      // irradiance: whatever is below is darkness

using Numbers = std::array<double, kShFloats>;

constexpr std::array<double, kScalesAnOctave> kSixteenths = {1.0,
                                                             1.0442737824274138,
                                                             1.0905077326652577,
                                                             1.1387886347566916,
                                                             1.1892071150027210,
                                                             1.2418578120734840,
                                                             1.2968395546510096,
                                                             1.3542555469368927,
                                                             1.4142135623730951,
                                                             1.4768261459394993,
                                                             1.5422108254079408,
                                                             1.6104903319492543,
                                                             1.6817928305074290,
                                                             1.7562521603732995,
                                                             1.8340080864093424,
                                                             1.9152065613971474};

// 2^(s / 16), the same bits on every machine.
double scaleOf(uint32_t s) { return std::ldexp(kSixteenths[s % kScalesAnOctave], static_cast<int>(s / kScalesAnOctave)); }

int bitsFor(uint32_t most) { return most == 0 ? 0 : 1 + std::ilogb(static_cast<double>(most)); }

// What irradiance takes of a coefficient: lengths are those of irradiance then.
double bandOf(size_t i) { return double{kCosineBand[i / kShChannels]}; }

double dot(const Numbers& a, const Numbers& b) { return std::inner_product(a.begin(), a.end(), b.begin(), 0.0); }

// Places fields one behind the other, none across two words.
class RecordLayout {
 public:
  void add(int bits) {
    if (bits == 0) {
      fields_.push_back({});
      return;
    }
    if (used_ % kWordBits + bits > kWordBits) used_ += kWordBits - used_ % kWordBits;
    fields_.push_back({used_ / kWordBits, used_ % kWordBits, bits});
    used_ += bits;
  }
  int words() const { return (used_ + kWordBits - 1) / kWordBits; }
  const std::vector<LightField>& fields() const { return fields_; }

 private:
  int used_ = 0;
  std::vector<LightField> fields_;
};

RecordLayout layoutOf(const PackedLight& packed) {
  RecordLayout layout;
  layout.add(packed.scale_bits);
  for (const LightAxis& axis : packed.axes) layout.add(axis.bits);
  return layout;
}

// ---- the level's axes

// Of a symmetric matrix by Jacobi's rotations: rows of *vectors, the largest eigenvalue first.
void principalAxes(std::array<Numbers, kShFloats> matrix, std::array<Numbers, kShFloats>* vectors) {
  constexpr int kMostSweeps = 30;
  constexpr double kTurnedFrom = 1e-30;  // squares, of both variances
  std::array<Numbers, kShFloats> rows{};
  for (size_t i = 0; i < kShFloats; ++i) rows[i][i] = 1.0;
  // Jacobi's method: sweeps over all pairs until none is correlated any more
  bool is_turned = true;
  for (int sweep = 0; sweep < kMostSweeps && is_turned; ++sweep) {
    is_turned = false;
    for (size_t p = 0; p < kShFloats; ++p) {
      for (size_t q = p + 1; q < kShFloats; ++q) {
        const double apart = matrix[p][q];
        if (!(apart * apart > kTurnedFrom * std::abs(matrix[p][p] * matrix[q][q]))) continue;
        is_turned = true;
        // the smaller of the two angles that make the pair uncorrelated
        const double ratio = (matrix[q][q] - matrix[p][p]) / (2.0 * apart);
        const double tangent = std::copysign(1.0, ratio) / (std::abs(ratio) + std::sqrt(ratio * ratio + 1.0));
        const double cosine = 1.0 / std::sqrt(tangent * tangent + 1.0), sine = tangent * cosine;
        const auto rotate = [&](double& of_p, double& of_q) {
          const double p_before = of_p, q_before = of_q;
          of_p = cosine * p_before - sine * q_before;
          of_q = sine * p_before + cosine * q_before;
        };
        for (size_t k = 0; k < kShFloats; ++k) rotate(matrix[p][k], matrix[q][k]);
        for (size_t k = 0; k < kShFloats; ++k) rotate(matrix[k][p], matrix[k][q]);
        for (size_t k = 0; k < kShFloats; ++k) rotate(rows[p][k], rows[q][k]);
      }
    }
  }
  // by variance: the first axes hold most of the light
  std::array<size_t, kShFloats> order;
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return matrix[a][a] > matrix[b][b]; });
  for (size_t i = 0; i < kShFloats; ++i) (*vectors)[i] = rows[order[i]];
}

// ---- bits

// What an axis costs of the error, by its bits: squares, summed over the probes that are sampled.
struct AxisChoice {
  std::array<double, kMostAxisBits + 1> error{};
  std::array<int32_t, kMostAxisBits + 1> offset{};
};

// steps   of the sampled probes along the axis, in units of the step
AxisChoice choiceOf(const std::vector<double>& steps) {
  AxisChoice choice;
  const auto [least, most] = std::minmax_element(steps.begin(), steps.end());
  const auto low = static_cast<int32_t>(std::nearbyint(*least)), high = static_cast<int32_t>(std::nearbyint(*most));
  const auto bins = static_cast<size_t>(high - low + 1);
  // of the numbers in the bins before one: how many, their sum and that of their squares, from `low` on
  std::vector<double> count(bins + 1, 0.0), sum(bins + 1, 0.0), squares(bins + 1, 0.0);
  double rounding = 0.0;
  for (const double step : steps) {
    const double nearest = std::nearbyint(step), from_low = step - low;
    const auto bin = static_cast<size_t>(nearest - low) + 1;
    count[bin] += 1.0, sum[bin] += from_low, squares[bin] += from_low * from_low;
    rounding += (step - nearest) * (step - nearest);
  }
  // as prefix sums, so that the cost of any window is a few operations
  for (size_t bin = 0; bin < bins; ++bin)
    count[bin + 1] += count[bin], sum[bin + 1] += sum[bin], squares[bin + 1] += squares[bin];
  // by bits: the window of so many numbers that loses least
  for (size_t bits = 0; bits <= kMostAxisBits; ++bits) {
    const size_t window = size_t{1} << bits;
    choice.error[bits] = std::numeric_limits<double>::infinity();
    for (size_t first = 0; first == 0 || first + window <= bins; ++first) {
      const size_t last = std::min(bins, first + window) - 1;
      const auto f = static_cast<double>(first), l = static_cast<double>(last);
      // what is outside comes to stand at the window's ends
      const double below = squares[first] - 2.0 * f * sum[first] + f * f * count[first];
      const double n = count[bins] - count[last + 1], s = sum[bins] - sum[last + 1], q = squares[bins] - squares[last + 1];
      const double error = below + q - 2.0 * l * s + l * l * n;
      if (error >= choice.error[bits]) continue;
      choice.error[bits] = error;
      choice.offset[bits] = low + static_cast<int32_t>(first);
    }
    choice.error[bits] += rounding;
  }
  return choice;
}

AxisChoice leftOut(const std::vector<double>& steps) {
  AxisChoice choice;
  choice.error.fill(std::inner_product(steps.begin(), steps.end(), steps.begin(), 0.0));
  return choice;
}

// Of how many bits each axis has, by the order in which bits pay most.
class BitsChoice {
 public:
  // choices   by axis, errors in squares of steps
  BitsChoice(std::vector<AxisChoice> choices, int scale_bits) : choices_(std::move(choices)), scale_bits_(scale_bits) {
    bits_.assign(choices_.size(), 0);
  }

  double error() const {
    double sum = 0.0;
    for (size_t k = 0; k < choices_.size(); ++k) sum += choices_[k].error[static_cast<size_t>(bits_[k])];
    return sum;
  }
  const std::vector<int>& bits() const { return bits_; }
  int32_t offset(size_t k) const { return choices_[k].offset[static_cast<size_t>(bits_[k])]; }

  // Gives bits while a record of so many words holds them.
  void fill(int words) {
    std::vector<int> most(choices_.size(), kMostAxisBits);  // by axis, what may still fit
    // greedily the widening that lowers the squared error most for each of its bits
    for (;;) {
      size_t best = choices_.size();
      int best_bits = 0;
      double best_gain = 0.0;
      for (size_t k = 0; k < choices_.size(); ++k) {
        const double now = choices_[k].error[static_cast<size_t>(bits_[k])];
        for (int bits = bits_[k] + 1; bits <= most[k]; ++bits) {
          const double gain = (now - choices_[k].error[static_cast<size_t>(bits)]) / (bits - bits_[k]);
          if (gain > best_gain) best = k, best_bits = bits, best_gain = gain;
        }
      }
      if (best == choices_.size()) return;
      std::vector<int> widened = bits_;
      widened[best] = best_bits;
      std::vector<size_t> axes;
      // an axis that finds no room may still be widened by fewer bits
      if (placed(widened, words, &axes)) {
        bits_ = widened;
      } else {
        most[best] = best_bits - 1;
      }
    }
  }

  // Axes in the order of a record: the widest first, each in the first word that has room.
  // returns  false where they do not fit
  bool order(int words, std::vector<size_t>* axes) const { return placed(bits_, words, axes); }

 private:
  bool placed(const std::vector<int>& bits, int words, std::vector<size_t>* axes) const {
    std::array<int, kMaxLightWords> room;
    room.fill(kWordBits);
    room[0] -= scale_bits_;
    std::vector<size_t> widest(bits.size());
    std::iota(widest.begin(), widest.end(), size_t{0});
    std::stable_sort(widest.begin(), widest.end(), [&](size_t a, size_t b) { return bits[a] > bits[b]; });
    std::array<std::vector<size_t>, kMaxLightWords> in_word;
    for (const size_t k : widest) {
      int word = 0;
      while (word < words && room[static_cast<size_t>(word)] < bits[k]) ++word;
      if (word == words) return false;
      room[static_cast<size_t>(word)] -= bits[k];
      in_word[static_cast<size_t>(word)].push_back(k);
    }
    axes->clear();
    for (const std::vector<size_t>& word : in_word) axes->insert(axes->end(), word.begin(), word.end());
    return true;
  }

  std::vector<AxisChoice> choices_;
  int scale_bits_;
  std::vector<int> bits_;
};

// ---- packing

class LightPacker {
 public:
  LightPacker(const std::vector<float>& light, double max_error) : light_(light), max_error_(max_error) {}

  LightPacking pack(PackedLight* packed) {
    *packed = {};
    measureLengths();
    if (lit_.empty()) return packing_;
    findAxes();
    // scales are sixteenths of octaves, from the darkest probe that is lit to the brightest; 0 is darkness
    const int scale_count = static_cast<int>(std::nearbyint(kScalesAnOctave * std::log2(most_ / least_))) + 1;
    scale_bits_ = bitsFor(static_cast<uint32_t>(scale_count));
    sampleSteps();
    chooseLayout(packed);
    return packing_;
  }

 private:
  size_t probeCount() const { return light_.size() / kShFloats; }

  Numbers irradianceOf(size_t probe) const {
    Numbers numbers;
    for (size_t i = 0; i < kShFloats; ++i) numbers[i] = bandOf(i) * double{light_[probe * kShFloats + i]};
    return numbers;
  }

  bool isDark(size_t probe) const { return !(length_[probe] > std::max(kDarkest, kDark * most_)); }

  void measureLengths() {
    length_.resize(probeCount());
    for (size_t probe = 0; probe < probeCount(); ++probe) {
      const Numbers irradiance = irradianceOf(probe);
      length_[probe] = std::sqrt(dot(irradiance, irradiance));
      most_ = std::max(most_, length_[probe]);
    }
    least_ = most_;
    for (size_t probe = 0; probe < probeCount(); ++probe) {
      if (isDark(probe)) {
        packing_.too_dark += length_[probe] > 0.0;
      } else {
        least_ = std::min(least_, length_[probe]);
        lit_.push_back(probe);
      }
    }
  }

  void findAxes() {
    std::array<Numbers, kShFloats> moments{};
    // of unit length each: a dark probe shapes the axes as much as a bright one
    for (const size_t probe : lit_) {
      Numbers unit = irradianceOf(probe);
      for (double& number : unit) number /= length_[probe];
      for (size_t i = 0; i < kShFloats; ++i) {
        for (size_t j = 0; j <= i; ++j) moments[i][j] += unit[i] * unit[j];
      }
    }
    for (size_t i = 0; i < kShFloats; ++i) {
      for (size_t j = i + 1; j < kShFloats; ++j) moments[i][j] = moments[j][i];
    }
    principalAxes(moments, &axes_);
  }

  uint32_t nearestScale(size_t probe) const {
    return 1 + static_cast<uint32_t>(std::nearbyint(kScalesAnOctave * std::log2(length_[probe] / least_)));
  }
  // of scale 0 were it none of darkness
  double firstScale() const { return least_ / scaleOf(1); }

  void sampleSteps() {
    const size_t every = (lit_.size() + kMostSampled - 1) / kMostSampled;
    for (auto& steps : sampled_) steps.clear();
    for (size_t n = 0; n < lit_.size(); n += every) {
      const Numbers irradiance = irradianceOf(lit_[n]);
      const double scale = firstScale() * scaleOf(nearestScale(lit_[n]));
      for (size_t k = 0; k < kShFloats; ++k) sampled_[k].push_back(dot(irradiance, axes_[k]) / scale);
    }
  }

  // An axis costs a shader 54 operations a pixel: the fewest that hold all but a quarter of the square of the error.
  size_t axisCount() const {
    constexpr double kLeftOut = 0.25;
    const double most = kLeftOut * max_error_ * max_error_ * static_cast<double>(sampled_[0].size());
    double left_out = 0.0;
    size_t count = kShFloats;
    for (; count > 1; --count) {
      const std::vector<double>& last = sampled_[count - 1];
      left_out += std::inner_product(last.begin(), last.end(), last.begin(), 0.0);
      if (left_out > most) break;
    }
    return count;
  }

  // Large steps leave bits for numbers far off: of those that keep the error the largest, in the fewest words.
  void chooseLayout(PackedLight* packed) {
    constexpr int kStepsTried = 24, kLargestStep = 16;  // sixths of octaves around the error itself
    std::vector<BitsChoice> by_step;
    for (int t = 0; t < kStepsTried; ++t) by_step.push_back(choicesAt(stepAt(t, kLargestStep)));
    // the fewest words for which some step keeps the error; the records themselves have the last word
    for (int words = 1; words <= kMaxLightWords; ++words) {
      int best = 0;
      double least = std::numeric_limits<double>::infinity();
      for (int t = 0; t < kStepsTried && least > max_error_; ++t) {
        BitsChoice& choice = by_step[static_cast<size_t>(t)];
        choice.fill(words);
        const double error = stepAt(t, kLargestStep) * std::sqrt(choice.error() / static_cast<double>(sampled_[0].size()));
        if (error < least) least = error, best = t;
      }
      if (least > max_error_ && words < kMaxLightWords) continue;
      writeLayout(by_step[static_cast<size_t>(best)], words, stepAt(best, kLargestStep), packed);
      writeRecords(stepAt(best, kLargestStep), packed);
      if (packing_.error <= max_error_) return;
    }
  }

  double stepAt(int t, int largest) const { return max_error_ * std::exp2((largest - t) / 6.0); }

  BitsChoice choicesAt(double step) const {
    std::vector<AxisChoice> choices;
    std::vector<double> steps;
    const size_t axes = axisCount();
    for (size_t k = 0; k < kShFloats; ++k) {
      steps.clear();
      for (const double length : sampled_[k]) steps.push_back(length / step);
      choices.push_back(k < axes ? choiceOf(steps) : leftOut(steps));
    }
    return {std::move(choices), scale_bits_};
  }

  void writeLayout(const BitsChoice& choice, int words, double step, PackedLight* packed) {
    *packed = {};
    packed->scale_bits = scale_bits_;
    packed->unit = static_cast<float>(step * firstScale());
    std::vector<size_t> order;
    choice.order(words, &order);
    axis_of_.clear();
    for (const size_t k : order) {
      const int bits = choice.bits()[k];
      if (bits == 0 && choice.offset(k) == 0) continue;
      LightAxis& axis = packed->axes.emplace_back();
      axis.bits = bits;
      axis.offset = choice.offset(k);
      for (size_t i = 0; i < kShFloats; ++i) {
        Half half;
        halfFromFloat(static_cast<float>(axes_[k][i] / bandOf(i)), &half);
        axis.direction[i] = half.bits;
      }
      axis_of_.push_back(k);
    }
  }

  void writeRecords(double step, PackedLight* packed) {
    const std::vector<LightField> fields = lightFields(*packed);
    const auto words = static_cast<size_t>(lightWords(*packed));
    packed->records.assign(probeCount() * words, 0);
    std::vector<Numbers> stored;  // axes as they are read, over the unit
    for (const LightAxis& axis : packed->axes) {
      Numbers& numbers = stored.emplace_back();
      for (size_t i = 0; i < kShFloats; ++i) numbers[i] = bandOf(i) * double{floatFromHalf({axis.direction[i]})};
    }
    // no scale is above that of the brightest probe: the layout's bits reach that far
    const uint32_t most_scale =
        nearestScale(static_cast<size_t>(std::max_element(length_.begin(), length_.end()) - length_.begin()));
    double squares = 0.0;
    packing_.worst = 0.0;
    std::vector<uint32_t> numbers(fields.size()), best(fields.size());
    for (const size_t probe : lit_) {
      const Numbers irradiance = irradianceOf(probe);
      std::array<double, kShFloats> along{};
      for (size_t k = 0; k < stored.size(); ++k) along[k] = dot(irradiance, axes_[axis_of_[k]]);
      // neighbouring scales round the others' numbers in other ways
      double least = std::numeric_limits<double>::infinity();
      const uint32_t nearest = nearestScale(probe);
      for (uint32_t s = std::max(1u, nearest - 1); s <= std::min(most_scale, nearest + 1); ++s) {
        const double scale = firstScale() * scaleOf(s) * step;
        numbers[0] = s;
        Numbers left = irradiance;
        for (size_t k = 0; k < stored.size(); ++k) {
          const LightAxis& axis = packed->axes[k];
          const double most = static_cast<double>((1 << axis.bits) - 1);
          const double number = std::clamp(std::nearbyint(along[k] / scale) - axis.offset, 0.0, most);
          numbers[k + 1] = static_cast<uint32_t>(number);
          for (size_t i = 0; i < kShFloats; ++i) left[i] -= scale * (number + axis.offset) * stored[k][i];
        }
        // relative to the probe's own light, because the eye sees ratios
        const double error = dot(left, left) / (length_[probe] * length_[probe]);
        if (error < least) least = error, best = numbers;
      }
      squares += least;
      packing_.worst = std::max(packing_.worst, std::sqrt(least));
      uint32_t* record = &packed->records[probe * words];
      for (size_t f = 0; f < fields.size(); ++f) {
        if (fields[f].bits > 0) record[fields[f].word] |= best[f] << fields[f].shift;
      }
    }
    packing_.error = std::sqrt(squares / static_cast<double>(lit_.size()));
  }

  const std::vector<float>& light_;
  double max_error_;
  std::vector<double> length_;  // by probe
  std::vector<size_t> lit_;
  double most_ = 0.0, least_ = 0.0;
  std::array<Numbers, kShFloats> axes_{};  // orthonormal, of irradiance
  std::array<std::vector<double>, kShFloats> sampled_;
  std::vector<size_t> axis_of_;  // of the packed axes
  int scale_bits_ = 0;
  LightPacking packing_;
};

FileResult refuse(FileStatus status, std::string detail) { return {status, std::move(detail)}; }

uint32_t maskOf(const LightField& field) { return (1u << field.bits) - 1; }

FileResult checkPacked(const PackedLight& packed, size_t probe_count) {
  const FileResult layout = checkLightLayout(packed);
  if (!layout.ok()) return layout;
  const int words = lightWords(packed);
  const size_t expected = probe_count * static_cast<size_t>(words);
  if (packed.records.size() != expected) {
    return refuse(FileStatus::tensor_unexpected,
                  "light.records: " + std::to_string(packed.records.size()) + " words; expected " + std::to_string(expected));
  }
  // bits that no field has must be 0, so that one light has one file
  std::array<uint32_t, kMaxLightWords> used{};
  for (const LightField& field : lightFields(packed)) used[static_cast<size_t>(field.word)] |= maskOf(field) << field.shift;
  for (size_t i = 0; i < packed.records.size(); ++i) {
    if ((packed.records[i] & ~used[i % static_cast<size_t>(words)]) != 0)
      return refuse(FileStatus::value_out_of_range, "light.records: bits without a meaning in word " + std::to_string(i));
  }
  return {};
}

// Unpacks the records of light that is checked, of probes with weight alone, group after group: into zeros.
void unpackRecords(const PackedLight& packed, const std::vector<uint32_t>& weighted, std::vector<std::vector<float>>* groups) {
  const std::vector<LightField> fields = lightFields(packed);
  const auto words = static_cast<size_t>(lightWords(packed));
  std::vector<Numbers> axes(packed.axes.size());
  for (size_t k = 0; k < axes.size(); ++k)
    std::transform(packed.axes[k].direction.begin(), packed.axes[k].direction.end(), axes[k].begin(),
                   [](uint16_t bits) { return floatFromHalf({bits}); });
  for (size_t i = 0; i < (words > 0 ? weighted.size() * groups->size() : 0); ++i) {
    float* const light = &(*groups)[i / weighted.size()][size_t{weighted[i % weighted.size()]} * kShFloats];
    const uint32_t* record = &packed.records[i * words];
    const uint32_t s = lightNumber(record, fields[0]);
    if (s == 0) continue;
    // exact until the last product: whatever a machine fuses, the floats are the same
    Numbers sum{};
    for (size_t k = 0; k < axes.size(); ++k) {
      const auto steps = static_cast<double>(static_cast<int32_t>(lightNumber(record, fields[k + 1])) + packed.axes[k].offset);
      for (size_t n = 0; n < kShFloats; ++n) sum[n] += steps * axes[k][n];
    }
    const double scale = double{packed.unit} * scaleOf(s);
    for (size_t n = 0; n < kShFloats; ++n) light[n] = static_cast<float>(scale * sum[n]);
  }
}

}  // namespace

FileResult checkLightLayout(const PackedLight& packed) {
  if (packed.axes.size() > kShFloats)
    return refuse(FileStatus::tensor_unexpected,
                  "light.offsets: " + std::to_string(packed.axes.size()) + " axes; expected at most 27");
  if (!(packed.unit > 0.0f && std::isfinite(packed.unit)))
    return refuse(FileStatus::value_out_of_range, "light.unit: expected a number above 0");
  if (packed.scale_bits < 0 || packed.scale_bits > kMostScaleBits)
    return refuse(FileStatus::value_out_of_range, "light.bits: value 0: expected 0 to 11 bits");
  for (size_t k = 0; k < packed.axes.size(); ++k) {
    const LightAxis& axis = packed.axes[k];
    const std::string place = ": value " + std::to_string(k);
    if (axis.bits < 0 || axis.bits > kMostAxisBits)
      return refuse(FileStatus::value_out_of_range, "light.bits: value " + std::to_string(k + 1) + ": expected 0 to 12 bits");
    if (std::abs(int64_t{axis.offset}) > 1 << kMostAxisBits)
      return refuse(FileStatus::value_out_of_range, "light.offsets" + place);
    for (size_t i = 0; i < kShFloats; ++i) {
      if (!std::isfinite(floatFromHalf({axis.direction[i]})))
        return refuse(FileStatus::value_not_finite, "light.axes: value " + std::to_string(k * kShFloats + i));
    }
  }
  // the words follow from widths that are checked by now
  const int words = lightWords(packed);
  if (words > kMaxLightWords)
    return refuse(FileStatus::value_out_of_range,
                  "light.bits: a record of " + std::to_string(words) + " words; expected at most 8");
  return {};
}

std::vector<LightField> lightFields(const PackedLight& packed) { return layoutOf(packed).fields(); }

int lightWords(const PackedLight& packed) { return layoutOf(packed).words(); }

LightPacking packLight(const std::vector<float>& light, double max_error, PackedLight* packed) {
  return LightPacker(light, max_error).pack(packed);
}

FileResult unpackGridLight(const PackedLight& packed, const std::vector<uint32_t>& probe_function, size_t group_count,
                           std::vector<std::vector<float>>* light) {
  std::vector<uint32_t> weighted;
  for (uint32_t probe = 0; probe < probe_function.size(); ++probe) {
    if (probe_function[probe] != kNoWeight) weighted.push_back(probe);
  }
  light->clear();
  FileResult result = checkPacked(packed, weighted.size() * group_count);
  if (!result.ok()) return result;
  light->resize(group_count);
  for (std::vector<float>& of_group : *light) of_group.resize(probe_function.size() * kShFloats);
  unpackRecords(packed, weighted, light);
  return {};
}

}  // namespace nlg
