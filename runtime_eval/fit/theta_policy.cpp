#include "runtime_eval/fit/theta_policy.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <numeric>

#include "runtime_eval/evaluator/product_field.h"
#include "runtime_eval/evaluator/theta_form.h"
#include "runtime_eval/fit/compensated_rounding.h"
#include "runtime_eval/fit/correction_stages.h"
#include "runtime_eval/fit/fit_stages.h"
#include "runtime_eval/fit/last_layer.h"
#include "runtime_eval/fit/policy_ranges.h"
#include "runtime_eval/numbers/flush_subnormals.h"

namespace nlg {
namespace {

// A representation that is wrong about the tent is so about every function, which no attempt changes: for it thresholds rise to so
// many times that error, at most to so many times retry_rmse.
constexpr double kOverTent = 1.25, kMostRetry = 2.0;
// Before iterations of Levenberg–Marquardt the first learned step gains more than it costs, and no other does.
constexpr int kStepsBeforeIterations = 1;

// Roundings to bytes that are tried for a theta, until one leaves it so many times the error that it had, or so much RMSE more: each
// number for itself in so many ways, then those that make up for each other. Few need a second one (docs/lab/training.md).
constexpr int kRoundingWays = 4;
constexpr Compensation kCompensations[] = {
    {{124, 124}, 0.03, 0}, {{118, 118}, 0.1, 3}, {{121, 121}, 0.01, 6}, {{112, 112}, 0.03, 9}};
constexpr double kRoundingExcess = 1.02, kRoundingAdds = 5e-5;
// What rounding made fail is fitted on to a check so many times as strict as the one before, and rounded again, so often at most. From
// the rounded theta and random starts: those that theta0 leads to may be as stiff as the one that did not bear rounding.
constexpr double kStricter = 0.9;
constexpr int kRoundingRefits = 3;

using Clock = std::chrono::steady_clock;
float microsecondsSince(Clock::time_point start) {
  return std::chrono::duration<float, std::micro>(Clock::now() - start).count();
}

size_t placeOf(ThetaStage stage) { return static_cast<size_t>(stage); }
size_t placeOf(ThetaWord word) { return static_cast<size_t>(word); }

void addTime(ThetaStage stage, ThetaWord word, float elapsed_us, ThetaRecord* record) {
  record->stage_us[placeOf(stage)] += elapsed_us;
  record->word_us[placeOf(word)] += elapsed_us;
}

std::unique_ptr<StageRun> makeStage(const StagePlan& plan, const Generator& generator, int learned_steps) {
  using Start = LevenbergMarquardtStage::Start;
  switch (plan.stage) {
    case ThetaStage::last_layer:
      return std::make_unique<LastLayerStage>(generator);
    case ThetaStage::learned_steps:
      return std::make_unique<LearnedStepsStage>(generator, plan.budget);
    case ThetaStage::mirror_images:
      return std::make_unique<MirrorImagesStage>(generator, plan.budget, plan.above_rmse, learned_steps);
    case ThetaStage::lm:
      return std::make_unique<LevenbergMarquardtStage>(generator, Start::theta, plan.budget);
    case ThetaStage::lm_theta0:
      return std::make_unique<LevenbergMarquardtStage>(generator, Start::theta0, plan.budget);
    case ThetaStage::adam:
      return std::make_unique<AdamStage>(generator, plan.budget);
    default:
      return nullptr;  // not of one batch: the policy's own
  }
}

// Fits drive the logits of product fields to any size where a larger one changes nothing. The largest half stands for all beyond it;
// what that does to the function, the check finds.
Theta limited(Theta theta) {
  for (float& number : theta) number = std::clamp(number, -kMaxHalf, kMaxHalf);
  return theta;
}

void roundLimited(const Representation& representation, ThetaPrecision precision, Theta* theta) {
  *theta = limited(std::move(*theta));
  roundTheta(representation, precision, theta->data());
}

}  // namespace

const char* outOfRange(const PolicyOptions& options) {
  const char* first = nullptr;
  // a NaN is in no range
  const auto judge = [&](const char* name, auto value, const auto& range) {
    if (first == nullptr && !(value >= range.low && value <= range.high)) first = name;
  };
  const PolicyRanges& may = kPolicyRanges;
  judge("bare_tent_rmse", options.bare_tent_rmse, may.rmse);
  judge("good_rmse", options.stages.good_rmse, may.rmse);
  judge("learned_steps", options.stages.learned_steps, may.learned_steps);
  judge("mirror_images", options.stages.mirror_images, may.mirror_images);
  judge("retry_rmse", options.stages.retry_rmse, may.rmse);
  judge("lm_iterations", options.stages.lm_iterations, may.lm_iterations);
  judge("lm_theta0_iterations", options.stages.lm_theta0_iterations, may.lm_iterations);
  judge("adam_rmse", options.stages.adam_rmse, may.rmse);
  judge("adam_steps", options.stages.adam_steps, may.adam_steps);
  judge("tau_rmse", options.check().tau_rmse, may.tau);
  judge("tau_leak", options.check().tau_leak, may.tau);
  judge("leak_share", options.check().leak_share, may.tau);
  judge("refine_rounds", options.refinement.rounds, may.refine_rounds);
  judge("refine_first_steps", options.refinement.first_steps, may.refine_first_steps);
  judge("refine_growth", options.refinement.growth, may.refine_growth);
  judge("refine_leak_weight", options.refinement.leak_weight, may.refine_leak_weight);
  judge("choice_flat_ratio", options.choice.flat_ratio, may.flat_ratio);
  judge("choice_enough_rmse", options.choice.enough_rmse, may.rmse);
  judge("choice_generator_excess", options.choice.generator_excess, may.generator_excess);
  return first;
}

bool takesBareTent(const FunctionCheck& tent, const PolicyOptions& options) {
  return options.bare_tent_rmse > 0.0 && tent.valid_count > 0 && tent.rmse <= options.bare_tent_rmse &&
         tent.passes(options.check());
}

bool isGood(const FunctionCheck& theta, double good_rmse, const CheckOptions& check) {
  return theta.rmse <= good_rmse && theta.passes(check);
}

StageFacts stageFacts(const Generator& generator) {
  const Representation& representation = generator.representation();
  const PointOrder& order = pointOrder(representation);
  std::vector<uint8_t> phi(kSupportPointCount);
  for (int p = 0; p < kSupportPointCount; ++p) {
    phi[p] = static_cast<uint8_t>(std::lround(255.0f * tent(supportPattern().points[p])));
  }
  GeneratorScratch scratch(generator);
  Theta theta(representation.thetaCount());
  generator.generate(phi.data(), 1, theta.data(), &scratch);
  const WeightingFunction function = tentFunction(order);
  if (generator.exactLastLayer()) solveLastLayer(representation, function, theta.data());
  return {representation, generator.exactLastLayer(), generator.correctionStepCount() > 0,
          functionRmse(representation, function, theta.data())};
}

std::vector<StagePlan> stagesOf(const StageFacts& facts, const PolicyOptions& options) {
  using Who = StagePlan::Who;
  const StageOptions& o = options.stages;
  const bool is_field = facts.representation.isField();
  const bool iterates = is_field && o.lm_iterations > 0;
  const double tent_rmse = std::isfinite(facts.tent_rmse) ? facts.tent_rmse : 0.0;
  const double least_rmse = std::min(kOverTent * tent_rmse, kMostRetry * o.retry_rmse);
  const double retry_rmse = std::max(o.retry_rmse, least_rmse);
  const int steps = facts.learned_steps ? std::min(o.learned_steps, iterates ? kStepsBeforeIterations : o.learned_steps) : 0;
  std::vector<StagePlan> plan;
  const auto add = [&](bool is_there, ThetaStage stage, Who who, double above_rmse, int budget) {
    if (is_there) plan.push_back({stage, who, above_rmse, budget});
  };
  add(true, ThetaStage::network, Who::all, 0.0, 0);
  add(facts.exact_last_layer, ThetaStage::last_layer, Who::wrong, o.good_rmse, 0);
  add(steps > 0, ThetaStage::learned_steps, Who::wrong, o.good_rmse, steps);
  // mirror images hardly help product fields
  add(!is_field && o.mirror_images > 1, ThetaStage::mirror_images, Who::above, retry_rmse, o.mirror_images);
  if (is_field) {
    add(o.lm_iterations > 0, ThetaStage::lm, Who::wrong, o.good_rmse, o.lm_iterations);
    add(o.lm_theta0_iterations > 0, ThetaStage::lm_theta0, Who::above, retry_rmse, o.lm_theta0_iterations);
  } else {
    add(o.adam_steps > 0, ThetaStage::adam, Who::above, std::max(o.adam_rmse, least_rmse), o.adam_steps);
  }
  add(options.refinement.rounds > 0, ThetaStage::refinement, Who::failing, 0.0, options.refinement.rounds);
  return plan;
}

double ThetaRecord::elapsedUs(ThetaWord word) const {
  return std::accumulate(word_us.begin(), word_us.begin() + static_cast<ptrdiff_t>(placeOf(word)) + 1, 0.0);
}

StageRunner::StageRunner(const Generator& generator, const PolicyOptions& options, ThetaStage last)
    : options_(options),
      plan_(stagesOf(stageFacts(generator), options)),
      batch_(generator),
      members_(kBatchCount),
      kept_(static_cast<size_t>(kBatchCount) * generator.representation().thetaCount()),
      kept_ended_(kBatchCount),
      before_(kBatchCount) {
  wrong_.reserve(kBatchCount);
  std::erase_if(plan_, [&](const StagePlan& plan) { return plan.stage > last; });
  int learned_steps = 0;
  for (const StagePlan& plan : plan_) {
    if (plan.stage == ThetaStage::learned_steps) learned_steps = plan.budget;
    if (std::unique_ptr<StageRun> run = makeStage(plan, generator, learned_steps)) stages_.push_back({plan, std::move(run)});
  }
}

StageRunner::~StageRunner() = default;

void StageRunner::make(const StoredFunction* functions, int count, float* theta, ThetaRecord* records, ThetaTrace* trace) {
  for (int begin = 0; begin < count; begin += kBatchCount) {
    runBatch(functions + begin, std::min(kBatchCount, count - begin), theta + begin * batch_.thetaCount(), records + begin, true,
             trace);
  }
}

void StageRunner::improve(const StoredFunction* functions, int count, float* theta, ThetaRecord* records, ThetaTrace* trace) {
  for (int begin = 0; begin < count; begin += kBatchCount) {
    runBatch(functions + begin, std::min(kBatchCount, count - begin), theta + begin * batch_.thetaCount(), records + begin, false,
             trace);
  }
}

void StageRunner::runBatch(const StoredFunction* functions, int count, float* theta, ThetaRecord* records, bool generates,
                           ThetaTrace* trace) {
  const size_t value_count = count * batch_.thetaCount();
  const auto keepTrace = [&](std::vector<float> ThetaTrace::*word) {
    if (trace != nullptr) (trace->*word).insert((trace->*word).end(), theta, theta + value_count);
  };
  const FlushSubnormals flush;
  const Clock::time_point start = Clock::now();
  batch_.begin(functions, count, theta);
  if (generates) batch_.generate();
  const float network_us = microsecondsSince(start) / static_cast<float>(count);
  for (int i = 0; i < count; ++i) {
    records[i] = {};
    addTime(ThetaStage::network, ThetaWord::network, network_us, &records[i]);
  }
  keepTrace(&ThetaTrace::network);
  checkAll(functions, records);
  ThetaWord word = ThetaWord::corrected;
  for (Stage& stage : stages_) {
    if (word != wordOf(stage.plan.stage)) {
      finishWord(word, functions, records);
      keepTrace(&ThetaTrace::corrected);
      word = wordOf(stage.plan.stage);
    }
    runStage(stage, records);
  }
  finishWord(word, functions, records);
  if (word == ThetaWord::corrected) {
    keepTrace(&ThetaTrace::corrected);
    for (int i = 0; i < count; ++i) records[i].at(ThetaWord::fitted) = records[i].at(ThetaWord::corrected);
  }
  keepTrace(&ThetaTrace::fitted);
  for (int i = 0; i < count; ++i) records[i].at(ThetaWord::stored) = records[i].at(ThetaWord::fitted);
}

void StageRunner::checkAll(const StoredFunction* functions, ThetaRecord* records) {
  wrong_.clear();
  for (int i = 0; i < batch_.count(); ++i) {
    const Clock::time_point start = Clock::now();
    const FunctionCheck check = checker_.check(batch_.representation(), functions[i], batch_.theta(i), options_.check());
    records[i].check.fill(check);
    if (!isGood(check, options_.stages.good_rmse, options_.check())) {
      wrong_.push_back(i);
      std::copy_n(batch_.theta(i), batch_.thetaCount(), &kept_[i * batch_.thetaCount()]);
      kept_ended_[i] = ThetaStage::network;
    }
    addTime(ThetaStage::check, ThetaWord::corrected, microsecondsSince(start), &records[i]);
  }
}

void StageRunner::runStage(Stage& stage, ThetaRecord* records) {
  const Clock::time_point start = Clock::now();
  // a mean square, so that no root is taken for every function
  const double above_square = stage.plan.who == StagePlan::Who::above ? stage.plan.above_rmse * stage.plan.above_rmse : 0.0;
  int member_count = 0;
  for (const int i : wrong_) {
    const double square = batch_.meanSquare(i);
    before_[i] = square;
    if (square > above_square) members_[member_count++] = i;
  }
  if (member_count == 0) return;
  // the stage may shorten its list: who took it is noted before
  const ThetaStage name = stage.plan.stage;
  if (isFit(name)) {
    for (int n = 0; n < member_count; ++n) records[members_[n]].took_fit = true;
  }
  stage.run->run(batch_, members_.data(), member_count);
  const float elapsed_us = microsecondsSince(start) / static_cast<float>(member_count);
  for (const int i : wrong_) {
    if (!(before_[i] > above_square)) continue;
    addTime(name, wordOf(name), elapsed_us, &records[i]);
    if (batch_.meanSquare(i) != before_[i]) records[i].ended = name;
  }
}

void StageRunner::finishWord(ThetaWord word, const StoredFunction* functions, ThetaRecord* records) {
  const size_t D = batch_.thetaCount();
  const ThetaWord previous = static_cast<ThetaWord>(placeOf(word) - 1);
  for (const int i : wrong_) {
    ThetaRecord& record = records[i];
    float* kept = &kept_[i * D];
    record.at(word) = record.at(previous);
    if (std::memcmp(kept, batch_.theta(i), D * sizeof(float)) == 0) continue;
    const Clock::time_point start = Clock::now();
    const FunctionCheck check = checker_.check(batch_.representation(), functions[i], batch_.theta(i), options_.check());
    // a lower error may leak more: what passed the check and would no longer stays as it was
    if (record.at(previous).passes(options_.check()) && !check.passes(options_.check())) {
      batch_.putBack(i, kept);
      record.ended = kept_ended_[i];
    } else {
      record.at(word) = check;
      std::copy_n(batch_.theta(i), D, kept);
      kept_ended_[i] = record.ended;
    }
    addTime(ThetaStage::check, word, microsecondsSince(start), &record);
  }
}

ThetaPolicy::ThetaPolicy(std::vector<const Generator*> generators, const PolicyOptions& options, ThetaStage last)
    : generators_(std::move(generators)), options_(options), last_(last) {
  if (options.theta_precision == ThetaPrecision::int8) compensated_ = std::make_unique<CompensatedRounding>();
  for (const Generator* generator : generators_) runners_.push_back(std::make_unique<StageRunner>(*generator, options, last));
}

ThetaPolicy::~ThetaPolicy() = default;

FunctionCheck ThetaPolicy::checkBareTent(const StoredFunction& function) {
  return checker_.checkBareTent(function, options_.check());
}

void ThetaPolicy::bake(const StoredFunction* functions, int count, MadeTheta* made, ThetaTrace* trace) {
  std::vector<StoredFunction> with_theta;
  std::vector<int> numbers;
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
    addTime(ThetaStage::bare_tent, ThetaWord::corrected, tent_us[i], &made[i].record);
  }
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
    addTime(ThetaStage::bare_tent, ThetaWord::corrected, tent_us[numbers[n]], &results[n].record);
    made[numbers[n]] = std::move(results[n]);
  }
}

void ThetaPolicy::make(const StoredFunction* functions, int count, MadeTheta* made, ThetaTrace* trace) {
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
    if (generators_.size() == 1 || isSmallestEnough(made[i].check(), options_.check(), options_.choice.forPredicted())) continue;
    made[i].larger_ran = true;
    others.push_back(all[i]);
    numbers.push_back(i);
  }
  if (others.empty()) return;
  std::vector<std::vector<float>> larger_theta(generators_.size());
  std::vector<std::vector<ThetaRecord>> larger(generators_.size());
  for (size_t g = 1; g < generators_.size(); ++g) larger[g] = makeAll(g, others, &larger_theta[g], nullptr);
  for (size_t n = 0; n < others.size(); ++n) {
    MadeTheta& one = made[numbers[n]];
    ThetaRecord tried = one.record;
    std::vector<FunctionCheck> checks = {one.check()};
    for (size_t g = 1; g < generators_.size(); ++g) {
      const ThetaRecord& record = larger[g][n];
      checks.push_back(record.at(ThetaWord::stored));
      tried.took_fit = tried.took_fit || record.took_fit;
      for (size_t s = 0; s < tried.stage_us.size(); ++s) tried.stage_us[s] += record.stage_us[s];
      for (size_t w = 0; w < tried.word_us.size(); ++w) tried.word_us[w] += record.word_us[w];
    }
    const int chosen = chooseRepresentation(checks, options_.check(), options_.choice.forPredicted());
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

void ThetaPolicy::refine(const StoredFunction& function, MadeTheta* made) {
  ThetaRecord& record = made->record;
  if (last_ < ThetaStage::refinement || options_.refinement.rounds <= 0 || record.at(ThetaWord::stored).passes(options_.check()))
    return;
  record.refined = record.took_fit = true;
  const size_t first = made->generator;
  double least_trouble = record.at(ThetaWord::stored).trouble(options_.check());
  for (size_t g = first; g < generators_.size() && least_trouble > 1.0; ++g) {
    const ThetaStage stage = g == first ? ThetaStage::refinement : ThetaStage::larger;
    if (stage > last_) break;
    const Clock::time_point start = Clock::now();
    const Theta begin = g == first ? made->theta : startOfLarger(function, g, *made);
    const RefinementResult refined =
        refiner_.refine(generators_[g]->representation(), function, begin, theta0(g), options_.refinement);
    record.refinement_stop = refined.stop;
    addTime(stage, ThetaWord::fitted, microsecondsSince(start), &record);
    const double trouble = refined.check.trouble(options_.check());
    if (!(trouble < least_trouble)) continue;
    least_trouble = trouble;
    made->generator = static_cast<uint8_t>(g);
    made->theta = refined.theta;
    record.at(ThetaWord::fitted) = record.at(ThetaWord::stored) = refined.check;
    record.ended = stage;
  }
}

void ThetaPolicy::round(const StoredFunction& function, MadeTheta* made) {
  if (last_ < ThetaStage::rounding || options_.theta_precision == ThetaPrecision::float32 || made->isBareTent()) return;
  const FlushSubnormals flush;
  const Clock::time_point start = Clock::now();
  const bool passed = made->check().passes(options_.check()), may_fit = last_ >= ThetaStage::refinement;
  Rounded rounded = roundOnce(function, *made);
  RefinementOptions stricter = options_.refinement;
  for (int refit = 0; refit < kRoundingRefits && passed && may_fit && stricter.rounds > 0; ++refit) {
    if (rounded.check.passes(options_.check())) break;
    stricter.check.tau_rmse *= kStricter;
    stricter.check.leak_share *= kStricter;
    RefinementResult refined =
        refiner_.refine(generators_[made->generator]->representation(), function, rounded.theta, {}, stricter);
    made->theta = std::move(refined.theta);
    made->record.at(ThetaWord::stored) = refined.check;
    made->record.refined = made->record.took_fit = true;
    made->record.refinement_stop = refined.stop;
    Rounded again = roundOnce(function, *made);
    if (again.check.trouble(options_.check()) < rounded.check.trouble(options_.check())) rounded = std::move(again);
    // a check that all rounds of steps did not reach is not reached where it is stricter still
    if (!refined.check.passes(stricter.check)) break;
  }
  made->theta = std::move(rounded.theta);
  made->record.at(ThetaWord::stored) = rounded.check;
  addTime(ThetaStage::rounding, ThetaWord::stored, microsecondsSince(start), &made->record);
}

ThetaPolicy::Rounded ThetaPolicy::roundOnce(const StoredFunction& function, const MadeTheta& made) {
  const bool has_bytes =
      options_.theta_precision == ThetaPrecision::int8 && !generators_[made.generator]->representation().isField();
  return has_bytes ? roundToBytes(function, made) : roundToHalves(function, made);
}

ThetaPolicy::Rounded ThetaPolicy::roundToHalves(const StoredFunction& function, const MadeTheta& made) {
  const Representation& representation = generators_[made.generator]->representation();
  Rounded rounded{made.theta, {}};
  roundLimited(representation, ThetaPrecision::float16, &rounded.theta);
  rounded.check = checker_.check(representation, function, rounded.theta.data(), options_.check());
  return rounded;
}

// The last layer makes up for what the hidden ones lose; but where refinement weighed leaks, the one that it left may leak less.
ThetaPolicy::Rounded ThetaPolicy::roundToBytes(const StoredFunction& function, const MadeTheta& made) {
  const Representation& representation = generators_[made.generator]->representation();
  const CheckOptions check = options_.check();
  // where a theta passes, its RMSE alone is what counts
  const auto badness = [&](const FunctionCheck& of) { return of.passes(check) ? of.rmse / check.tau_rmse : of.trouble(check); };
  const double before = badness(made.check()),
               enough = std::max(kRoundingExcess * before, before + kRoundingAdds / check.tau_rmse);
  Rounded best;
  const auto isDone = [&] { return !best.theta.empty() && badness(best.check) <= enough; };
  const auto offer = [&](Theta theta) {
    roundLimited(representation, ThetaPrecision::int8, &theta);
    const FunctionCheck found = checker_.check(representation, function, theta.data(), check);
    if (best.theta.empty() || badness(found) < badness(best.check)) best = {std::move(theta), found};
  };
  const Theta start = limited(made.theta);  // scaled units of larger numbers would leave the range of floats
  const WeightingFunction values = decodeFunction(function, pointOrder(representation), 0);
  const auto offerSolvedAndNot = [&](Theta theta) {
    Theta solved = theta;
    if (solveLastLayer(representation, values, solved.data())) offer(std::move(solved));
    if (!isDone()) offer(std::move(theta));
  };
  for (int way = 0; way < kRoundingWays && !isDone(); ++way) {
    Theta theta = start;
    roundHiddenLayers(representation, theta.data(), {kMostThetaSteps - 2 * way, kMostThetaSteps});
    offerSolvedAndNot(std::move(theta));
  }
  if (isDone()) return best;
  WeightingFunction fitted = values;
  if (made.record.refined) weighLeaks(options_.refinement.leak_weight, &fitted);
  for (const Compensation& compensation : kCompensations) {
    Theta theta = start;
    if (isDone() || !compensated_->round(representation, fitted, compensation, theta.data())) continue;
    offerSolvedAndNot(std::move(theta));
  }
  return best;
}

Theta ThetaPolicy::theta0(size_t g) const {
  return {generators_[g]->theta0(), generators_[g]->theta0() + generators_[g]->representation().thetaCount()};
}

// What its own generator makes, or a field that is smaller so far, on its finer grid.
Theta ThetaPolicy::startOfLarger(const StoredFunction& function, size_t g, const MadeTheta& present) {
  const Representation &larger = generators_[g]->representation(), &smaller = generators_[present.generator]->representation();
  Theta own(larger.thetaCount());
  ThetaRecord record;
  runners_[g]->make(&function, 1, own.data(), &record);
  if (!larger.isField() || !smaller.isField()) return own;
  Theta finer(larger.thetaCount());
  resampleField(smaller.resolution, present.theta.data(), larger.resolution, finer.data());
  const bool finer_is_better =
      checker_.check(larger, function, finer.data(), options_.check()).rmse < record.at(ThetaWord::stored).rmse;
  return finer_is_better ? finer : own;
}

}  // namespace nlg
