#include <algorithm>
#include <utility>

#include "nlg/policy.h"
#include "runtime_eval/evaluator/product_field.h"
#include "runtime_eval/numbers/flush_subnormals.h"
#include "runtime_eval/policy/refinement.h"
#include "runtime_eval/policy/representation_choice.h"
#include "runtime_eval/policy/stage_runner.h"
#include "runtime_eval/policy/theta_rounding.h"

namespace nlg {
namespace {

using Clock = std::chrono::steady_clock;

// What rounding made fail is fitted on, against a check that is kStricter times what it was, and rounded again: at most
// kRoundingRefits times, each time more strictly. These fits start from the rounded theta and from random ones: those that theta0 leads
// to may be as stiff as the one that did not bear rounding.
constexpr double kStricter = 0.9;
constexpr int kRoundingRefits = 3;

// Of the dark points of a function: at no larger a share may its bare tent leak. It lets all of itself through there, at a few points too far
// out to show in any RMSE; in a dark room beside daylight they are seen (docs/lab/training.md).
constexpr double kTentLeakShare = 0.01;

}  // namespace

const char* outOfRange(const PolicyOptions& options) {
// a NaN is in no range
#define NLG_POLICY_OPTION(type, name, value, low, high, help) \
  if (!(options.name >= (low) && options.name <= (high))) return #name;
#include "nlg/policy_options.def"
  return nullptr;
}

bool takesBareTent(const FunctionCheck& tent, const PolicyOptions& options) {
  return options.bare_tent_rmse > 0.0 && tent.valid_count > 0 && tent.blend_rmse <= options.bare_tent_rmse &&
         tent.leak_share <= kTentLeakShare && tent.passes(options.check());
}

struct ThetaPolicy::Stages {
  Stages(std::vector<const Generator*> of, const PolicyOptions& options, ThetaStage last)
      : generators_(std::move(of)), options_(options), last_(last), rounding_(options) {
    for (const Generator* generator : generators_) runners_.push_back(std::make_unique<StageRunner>(*generator, options, last));
  }

  void bake(const StoredFunction* functions, int count, MadeTheta* made, ThetaTrace* trace);
  FunctionCheck checkBareTent(const StoredFunction& function);
  void make(const StoredFunction* functions, int count, MadeTheta* made, ThetaTrace* trace);
  void refine(const StoredFunction& function, MadeTheta* made);
  void round(const StoredFunction& function, MadeTheta* made);
  Theta theta0(size_t generator) const;
  Theta startOfLarger(const StoredFunction& function, size_t generator, const MadeTheta& present);

  std::vector<const Generator*> generators_;
  PolicyOptions options_;
  ThetaStage last_;
  std::vector<std::unique_ptr<StageRunner>> runners_;  // by generator
  Refiner refiner_;
  ThetaRounding rounding_;
  FunctionChecker checker_;
};

ThetaPolicy::ThetaPolicy(std::vector<const Generator*> generators, const PolicyOptions& options, ThetaStage last)
    : stages_(std::make_unique<Stages>(std::move(generators), options, last)) {}
ThetaPolicy::~ThetaPolicy() = default;
ThetaPolicy::ThetaPolicy(ThetaPolicy&&) noexcept = default;
ThetaPolicy& ThetaPolicy::operator=(ThetaPolicy&&) noexcept = default;

const PolicyOptions& ThetaPolicy::options() const { return stages_->options_; }
const std::vector<StagePlan>& ThetaPolicy::plan(size_t generator) const { return stages_->runners_[generator]->plan(); }
void ThetaPolicy::bake(const StoredFunction* functions, int count, MadeTheta* made, ThetaTrace* trace) {
  stages_->bake(functions, count, made, trace);
}
FunctionCheck ThetaPolicy::checkBareTent(const StoredFunction& function) { return stages_->checkBareTent(function); }
void ThetaPolicy::make(const StoredFunction* functions, int count, MadeTheta* made, ThetaTrace* trace) {
  stages_->make(functions, count, made, trace);
}
void ThetaPolicy::refine(const StoredFunction& function, MadeTheta* made) { stages_->refine(function, made); }
void ThetaPolicy::round(const StoredFunction& function, MadeTheta* made) { stages_->round(function, made); }

FunctionCheck ThetaPolicy::Stages::checkBareTent(const StoredFunction& function) {
  return checker_.checkBareTent(function, options_.check());
}

void ThetaPolicy::Stages::bake(const StoredFunction* functions, int count, MadeTheta* made, ThetaTrace* trace) {
  std::vector<StoredFunction> with_theta;
  std::vector<int> numbers;
  // the cheapest first: a function that its bare tent serves takes no theta
  std::vector<float> tent_us(count);
  for (int i = 0; i < count; ++i) {
    const Clock::time_point start = Clock::now();
    const FunctionCheck tent = checkBareTent(functions[i]);
    tent_us[i] = microsecondsSince(start);
    if (!takesBareTent(tent, options_)) {
      with_theta.push_back(functions[i]);
      numbers.push_back(i);
      continue;
    }
    made[i] = {};
    made[i].record.check.fill(tent);
    made[i].record.ended = ThetaStage::bare_tent;
    made[i].record.addTime(ThetaStage::bare_tent, ThetaWord::corrected, tent_us[i]);
  }
  // all others go through the stages together: the generator is fast in batches
  std::vector<MadeTheta> results(with_theta.size());
  const size_t traced = trace != nullptr ? trace->fitted.size() : 0;
  make(with_theta.data(), static_cast<int>(with_theta.size()), results.data(), trace);
  for (size_t n = 0; n < results.size(); ++n) {
    refine(with_theta[n], &results[n]);
    // the refinement is a fit like any other
    if (trace != nullptr && results[n].generator == 0) {
      std::copy(results[n].theta.begin(), results[n].theta.end(),
                trace->fitted.begin() + static_cast<ptrdiff_t>(traced + n * results[n].theta.size()));
    }
    round(with_theta[n], &results[n]);
    results[n].record.addTime(ThetaStage::bare_tent, ThetaWord::corrected, tent_us[numbers[n]]);
    made[numbers[n]] = std::move(results[n]);
  }
}

void ThetaPolicy::Stages::make(const StoredFunction* functions, int count, MadeTheta* made, ThetaTrace* trace) {
  const auto makeAll = [&](size_t g, const std::vector<StoredFunction>& some, std::vector<float>* theta, ThetaTrace* of) {
    theta->resize(some.size() * generators_[g]->representation().thetaCount());
    std::vector<ThetaRecord> records(some.size());
    runners_[g]->make(some.data(), static_cast<int>(some.size()), theta->data(), records.data(), of);
    return records;
  };
  const auto thetaOf = [&](size_t g, const std::vector<float>& theta, size_t n) {
    const size_t D = static_cast<size_t>(generators_[g]->representation().thetaCount());
    return Theta(&theta[n * D], &theta[n * D] + D);
  };
  // the smallest representation for all functions, the larger ones for those that it may not be enough for
  const std::vector<StoredFunction> all(functions, functions + count);
  std::vector<float> theta;
  const std::vector<ThetaRecord> smallest = makeAll(0, all, &theta, trace);
  std::vector<StoredFunction> others;
  std::vector<int> numbers;
  for (int i = 0; i < count; ++i) {
    made[i] = {0, false, thetaOf(0, theta, i), smallest[i]};
    if (generators_.size() == 1 || isSmallestEnough(made[i].check(), options_, options_.forPredicted())) continue;
    made[i].larger_ran = true;
    others.push_back(all[i]);
    numbers.push_back(i);
  }
  if (others.empty()) return;
  // the choice needs the errors of all larger ones
  std::vector<std::vector<float>> larger_theta(generators_.size());
  std::vector<std::vector<ThetaRecord>> larger(generators_.size());
  for (size_t g = 1; g < generators_.size(); ++g) larger[g] = makeAll(g, others, &larger_theta[g], nullptr);
  for (size_t n = 0; n < others.size(); ++n) {
    MadeTheta& one = made[numbers[n]];
    // all tries count in time and fits, whichever is chosen
    ThetaRecord tried = one.record;
    std::vector<FunctionCheck> checks = {one.check()};
    for (size_t g = 1; g < generators_.size(); ++g) {
      const ThetaRecord& record = larger[g][n];
      checks.push_back(record.at(ThetaWord::stored));
      tried.took_fit = tried.took_fit || record.took_fit;
      for (size_t s = 0; s < tried.stage_us.size(); ++s) tried.stage_us[s] += record.stage_us[s];
      for (size_t w = 0; w < tried.word_us.size(); ++w) tried.word_us[w] += record.word_us[w];
    }
    const int chosen = chooseRepresentation(checks, options_.check(), options_.forPredicted());
    if (chosen > 0) {
      one.generator = static_cast<uint8_t>(chosen);
      one.theta = thetaOf(chosen, larger_theta[chosen], n);
      one.record = larger[chosen][n];
    }
    one.record.took_fit = tried.took_fit;
    one.record.stage_us = tried.stage_us;
    one.record.word_us = tried.word_us;
  }
}

void ThetaPolicy::Stages::refine(const StoredFunction& function, MadeTheta* made) {
  ThetaRecord& record = made->record;
  if (last_ < ThetaStage::refinement || options_.refine_rounds <= 0 || record.at(ThetaWord::stored).passes(options_.check()))
    return;
  record.refined = record.took_fit = true;
  // the present representation first, then larger ones as long as the check fails; each is kept only if in less trouble
  const size_t first = made->generator;
  double least_trouble = record.at(ThetaWord::stored).trouble(options_.check());
  for (size_t g = first; g < generators_.size() && least_trouble > 1.0; ++g) {
    const ThetaStage stage = g == first ? ThetaStage::refinement : ThetaStage::larger;
    if (stage > last_) break;
    const Clock::time_point start = Clock::now();
    const Theta begin = g == first ? made->theta : startOfLarger(function, g, *made);
    const RefinementResult refined =
        refiner_.refine(generators_[g]->representation(), function, begin, theta0(g), options_, options_);
    record.refinement_stop = refined.stop;
    record.addTime(stage, ThetaWord::fitted, microsecondsSince(start));
    const double trouble = refined.check.trouble(options_.check());
    if (!(trouble < least_trouble)) continue;
    least_trouble = trouble;
    made->generator = static_cast<uint8_t>(g);
    made->theta = refined.theta;
    record.at(ThetaWord::fitted) = record.at(ThetaWord::stored) = refined.check;
    record.ended = stage;
  }
}

void ThetaPolicy::Stages::round(const StoredFunction& function, MadeTheta* made) {
  if (last_ < ThetaStage::rounding || options_.theta_precision == ThetaPrecision::float32 || made->isBareTent()) return;
  const FlushSubnormals flush;
  const Clock::time_point start = Clock::now();
  const Representation& representation = generators_[made->generator]->representation();
  ThetaRecord& record = made->record;
  const auto roundPresent = [&] {
    return rounding_.round(representation, function, {made->theta, made->check()}, options_.check());
  };
  // only what passed before is fitted on for the sake of its rounding
  const bool passed = made->check().passes(options_.check());
  const bool may_refit = passed && last_ >= ThetaStage::refinement && options_.refine_rounds > 0;
  RoundedTheta rounded = roundPresent();
  CheckOptions stricter = options_.check();
  for (int refit = 0; refit < kRoundingRefits && may_refit && !rounded.check.passes(options_.check()); ++refit) {
    stricter.tau_rmse *= kStricter;
    stricter.tau_blend *= kStricter;
    RefinementResult refined = refiner_.refine(representation, function, rounded.theta, {}, stricter, options_);
    made->theta = std::move(refined.theta);
    record.at(ThetaWord::stored) = refined.check;
    record.refined = record.took_fit = true;
    record.refinement_stop = refined.stop;
    RoundedTheta again = roundPresent();
    if (again.check.trouble(options_.check()) < rounded.check.trouble(options_.check())) rounded = std::move(again);
    // a check that all rounds of steps did not reach is not reached where it is stricter still
    if (!refined.check.passes(stricter)) break;
  }
  made->theta = std::move(rounded.theta);
  record.at(ThetaWord::stored) = rounded.check;
  record.addTime(ThetaStage::rounding, ThetaWord::stored, microsecondsSince(start));
}

Theta ThetaPolicy::Stages::theta0(size_t g) const {
  return {generators_[g]->theta0(), generators_[g]->theta0() + generators_[g]->representation().thetaCount()};
}

// What its own generator makes, or a field that is smaller so far, on its finer grid.
Theta ThetaPolicy::Stages::startOfLarger(const StoredFunction& function, size_t g, const MadeTheta& present) {
  const Representation &larger = generators_[g]->representation(), &smaller = generators_[present.generator]->representation();
  Theta own(larger.thetaCount());
  ThetaRecord record;
  runners_[g]->make(&function, 1, own.data(), &record);
  if (!larger.isField() || !smaller.isField()) return own;
  Theta finer(larger.thetaCount());
  resampleField(smaller.resolution, present.theta.data(), larger.resolution, finer.data());
  const FunctionCheck of_finer = checker_.check(larger, function, finer.data(), options_.check());
  const bool finer_is_better = of_finer.blend_rmse < record.at(ThetaWord::stored).blend_rmse;
  return finer_is_better ? finer : own;
}

}  // namespace nlg
