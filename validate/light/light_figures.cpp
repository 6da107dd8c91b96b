#include "validate/light/light_figures.h"

#include <algorithm>
#include <cmath>

#include "runtime_eval/numbers/random.h"
#include "tool/parallel_for.h"
#include "validate/generators/statistics.h"

namespace nlg {
namespace {

constexpr uint64_t kTruthStream = 0x7472757468, kWalkStream = 0x77616c6b;

double channelMean(const glm::vec3& rgb) { return (double{rgb.r} + rgb.g + rgb.b) / 3.0; }
double squares(const glm::vec3& rgb) { return (double{rgb.r} * rgb.r + double{rgb.g} * rgb.g + double{rgb.b} * rgb.b) / 3.0; }
double absolutes(const glm::vec3& rgb) { return double{std::fabs(rgb.r)} + std::fabs(rgb.g) + std::fabs(rgb.b); }
double quotient(double a, double b) { return b > 0.0 ? a / b : 0.0; }
double energyOf(double answer, double truth) { return truth > 0.0 ? answer / truth : 1.0; }

// Steps of walks measure changes; places nearer than 5 cm and those at edges are figures of their own.
bool isCounted(const LightPlace& place) {
  const bool is_before = place.group == PlaceGroup::surface || place.group == PlaceGroup::turned;
  return place.group == PlaceGroup::air || (is_before && place.surface_class >= kFirstFarClass);
}

class GroupSum {
 public:
  // truth_mean   of the level
  explicit GroupSum(double truth_mean) : black_(kBlackShare * truth_mean) {}

  void add(const glm::vec3& truth, const LightAnswer& answer, double weight) {
    ++figures_.places;
    weight_ += weight;
    error_ += weight * squares(answer.irradiance - truth);
    truth_ += weight * squares(truth);
    given_mean_ += weight * channelMean(answer.irradiance);
    truth_mean_ += weight * channelMean(truth);
    // what is below a hundredth of the level's mean is black to an eye: no share of it is an error
    const double sum = std::max(absolutes(answer.irradiance) + absolutes(truth), black_);
    smape_ += weight * quotient(absolutes(answer.irradiance - truth), sum);
    unlit_ += weight * (answer.reach == Reach::unlit);
    outside_ += weight * (answer.reach == Reach::outside);
  }

  GroupFigures figures() {
    figures_.rmse = std::sqrt(quotient(error_, truth_));
    figures_.energy = energyOf(given_mean_, truth_mean_);
    figures_.smape = quotient(smape_, weight_);
    figures_.unlit = quotient(unlit_, weight_);
    figures_.outside = quotient(outside_, weight_);
    return figures_;
  }

 private:
  const double black_;
  GroupFigures figures_;
  double weight_ = 0.0, error_ = 0.0, truth_ = 0.0, smape_ = 0.0, unlit_ = 0.0, outside_ = 0.0;
  double given_mean_ = 0.0, truth_mean_ = 0.0;
};

// Sums by room. Places in no room have none.
class RoomSums {
 public:
  explicit RoomSums(const LightPlaces& places) : count_(places.room_count), weight_(places.room_count), sum_(places.room_count) {}

  void add(const LightPlace& place, double value, double weight) {
    if (place.room >= count_.size()) return;
    ++count_[place.room];
    weight_[place.room] += weight;
    sum_[place.room] += weight * value;
  }
  bool says(uint32_t room) const { return room < count_.size() && count_[room] >= kLeastOfRoom; }
  double mean(uint32_t room) const { return quotient(sum_[room], weight_[room]); }

 private:
  std::vector<uint64_t> count_;
  std::vector<double> weight_, sum_;
};

// weight   of a place in the group; 0: not in it
template <class Weight>
void balance(const LightPlaces& places, const LightTruth& truth, const std::vector<LightAnswer>& answers, Weight weight,
             GroupFigures* figures) {
  RoomSums light(places), errors(places);
  for (size_t i = 0; i < places.places.size(); ++i) {
    const LightPlace& place = places.places[i];
    if (!(weight(place) > 0.0)) continue;
    light.add(place, channelMean(truth.at[i].irradiance), weight(place));
  }
  for (size_t i = 0; i < places.places.size(); ++i) {
    const LightPlace& place = places.places[i];
    if (!(weight(place) > 0.0) || !light.says(place.room)) continue;
    const double own = std::max(channelMean(truth.at[i].irradiance), light.mean(place.room));
    const double scale = std::max(own, kBlackShare * truth.mean);
    errors.add(place, quotient(squares(answers[i].irradiance - truth.at[i].irradiance), scale * scale), weight(place));
  }
  for (uint32_t room = 0; room < places.room_count; ++room) {
    if (!errors.says(room)) continue;
    ++figures->rooms;
    figures->balanced += std::sqrt(errors.mean(room));
  }
  figures->balanced = quotient(figures->balanced, static_cast<double>(figures->rooms));
}

ExcessFigures darkFigures(const LightPlaces& places, const LightTruth& truth, const std::vector<LightAnswer>& answers) {
  ExcessFigures dark;
  for (size_t i = 0; i < places.places.size(); ++i) {
    const double light = channelMean(truth.at[i].irradiance);
    if (!isCounted(places.places[i]) || light >= kDarkShare * truth.mean) continue;
    ++dark.places;
    dark.excess += channelMean(answers[i].irradiance) - light;
  }
  dark.excess = quotient(dark.excess, static_cast<double>(dark.places) * truth.mean);
  return dark;
}

ExcessFigures edgeFigures(const LightPlaces& places, const LightTruth& truth, const std::vector<LightAnswer>& answers,
                          PlaceGroup group) {
  ExcessFigures figures;
  double light = 0.0, answered = 0.0;
  for (size_t i = 0; i < places.places.size(); ++i) {
    if (places.places[i].group != group) continue;
    ++figures.places;
    light += channelMean(truth.at[i].irradiance);
    answered += channelMean(answers[i].irradiance);
  }
  figures.excess = quotient(answered - light, light);
  return figures;
}

WalkFigures walkFigures(const LightPlaces& places, const LightTruth& truth, const std::vector<LightAnswer>& answers) {
  std::vector<double> jumps;
  for (size_t i = 1; i < places.places.size(); ++i) {
    const LightPlace &from = places.places[i - 1], &to = places.places[i];
    if (from.group != PlaceGroup::walk || to.group != PlaceGroup::walk || from.walk != to.walk) continue;
    const double answer = std::sqrt(squares(answers[i].irradiance - answers[i - 1].irradiance));
    const double expected = std::sqrt(squares(truth.at[i].irradiance - truth.at[i - 1].irradiance));
    jumps.push_back(quotient(std::max(0.0, answer - expected), truth.rms));
  }
  const Quantiles q = quantiles(jumps);
  return {q.count, q.mean, q.worst};
}

std::vector<WorstPlace> worstPlaces(const LightPlaces& places, const LightTruth& truth, const std::vector<LightAnswer>& answers) {
  std::vector<WorstPlace> all;
  for (uint32_t i = 0; i < places.places.size(); ++i) {
    if (!isCounted(places.places[i])) continue;
    all.push_back({i, quotient(std::sqrt(squares(answers[i].irradiance - truth.at[i].irradiance)), truth.rms)});
  }
  const size_t kept = std::min(all.size(), kWorstPlaceCount);
  std::partial_sort(
      all.begin(), all.begin() + static_cast<std::ptrdiff_t>(kept), all.end(),
      [](const WorstPlace& a, const WorstPlace& b) { return a.error != b.error ? a.error > b.error : a.place < b.place; });
  all.resize(kept);
  return all;
}

}  // namespace

LightTruth lightTruth(const LightPlaces& places, const LightTransport& transport, const TruthOptions& options) {
  LightTruth truth;
  truth.at.resize(places.places.size());
  parallelFor(places.places.size(), options.threads, [&](uint64_t i, int) {
    const LightPlace& place = places.places[i];
    // the same rays at all steps of a walk: what changes between steps is light, not noise
    const uint64_t place_seed =
        place.group == PlaceGroup::walk ? mixSeed(options.seed, kWalkStream, place.walk) : mixSeed(options.seed, kTruthStream, i);
    truth.at[i] = transport.gatherIrradiance(place.position_m, place.normal, options.gather, place_seed);
  });
  // over points in air alone: those before surfaces are drawn by classes of distance
  double count = 0.0, noise = 0.0, light = 0.0;
  for (size_t i = 0; i < truth.at.size(); ++i) {
    if (places.places[i].group != PlaceGroup::air) continue;
    count += 1.0;
    truth.mean += channelMean(truth.at[i].irradiance);
    light += squares(truth.at[i].irradiance);
    noise += squares(truth.at[i].deviation);
  }
  truth.mean = quotient(truth.mean, count);
  truth.rms = std::sqrt(quotient(light, count));
  truth.noise = std::sqrt(quotient(noise, light));
  // places that count as dark, for the reader to know how many leaks are measured on
  for (size_t i = 0; i < truth.at.size(); ++i)
    truth.dark += isCounted(places.places[i]) && channelMean(truth.at[i].irradiance) < kDarkShare * truth.mean;
  return truth;
}

std::vector<Receiver> receiversAt(const LightPlaces& places) {
  std::vector<Receiver> receivers;
  for (const LightPlace& place : places.places) receivers.push_back({place.position_m, place.normal});
  return receivers;
}

LightFigures lightFigures(const LightPlaces& places, const LightTruth& truth, const std::vector<LightAnswer>& answers) {
  GroupSum air(truth.mean), surface(truth.mean), turned(truth.mean);
  std::vector<GroupSum> surface_class(kSurfaceClassCount, GroupSum(truth.mean)), turned_class = surface_class;
  // each group by itself; surfaces weigh by their class of distance
  for (size_t i = 0; i < places.places.size(); ++i) {
    const LightPlace& place = places.places[i];
    const glm::vec3& expected = truth.at[i].irradiance;
    if (place.group == PlaceGroup::air) air.add(expected, answers[i], 1.0);
    if (place.group != PlaceGroup::surface && place.group != PlaceGroup::turned) continue;
    const bool is_turned = place.group == PlaceGroup::turned;
    (is_turned ? turned_class : surface_class)[place.surface_class].add(expected, answers[i], 1.0);
    if (isCounted(place)) (is_turned ? turned : surface).add(expected, answers[i], places.surfaceWeight(place.surface_class));
  }
  // plain figures over all points of a group
  LightFigures figures;
  figures.air = air.figures();
  figures.surface = surface.figures();
  figures.turned = turned.figures();
  for (int c = 0; c < kSurfaceClassCount; ++c) {
    figures.surface_class[c] = surface_class[c].figures();
    figures.turned_class[c] = turned_class[c].figures();
  }
  // the same by room: every room weighs alike
  const auto of_air = [](const LightPlace& p) { return p.group == PlaceGroup::air ? 1.0 : 0.0; };
  balance(places, truth, answers, of_air, &figures.air);
  for (const auto& [group, of_group] :
       {std::pair(PlaceGroup::surface, &figures.surface), {PlaceGroup::turned, &figures.turned}}) {
    const auto weight = [&places, g = group](const LightPlace& p) {
      return p.group == g ? places.surfaceWeight(p.surface_class) : 0.0;
    };
    balance(places, truth, answers, weight, of_group);
  }
  figures.dark = darkFigures(places, truth, answers);
  figures.edge = edgeFigures(places, truth, answers, PlaceGroup::edge);
  figures.corner = edgeFigures(places, truth, answers, PlaceGroup::corner);
  figures.jumps = walkFigures(places, truth, answers);
  figures.worst = worstPlaces(places, truth, answers);
  return figures;
}

}  // namespace nlg
