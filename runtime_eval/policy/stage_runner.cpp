#include "runtime_eval/policy/stage_runner.h"

#include <algorithm>
#include <cstring>

#include "runtime_eval/evaluator/generator/projection.h"
#include "runtime_eval/numbers/flush_subnormals.h"

namespace nlg {

using Clock = std::chrono::steady_clock;

StageRunner::StageRunner(const Generator& generator, const PolicyOptions& options, ThetaStage last)
    : options_(options),
      plan_(stagesOf(stageFacts(generator), options)),
      batch_(generator, options.check().loss()),
      members_(kBatchCount),
      kept_(static_cast<size_t>(kBatchCount) * generator.representation().thetaCount()),
      kept_ended_(kBatchCount),
      before_(kBatchCount) {
  wrong_.reserve(kBatchCount);
  std::erase_if(plan_, [&](const StagePlan& plan) { return plan.stage > last; });
  for (const StagePlan& plan : plan_) {
    if (std::unique_ptr<StageRun> run = makeStage(plan, generator)) stages_.push_back({plan, std::move(run)});
  }
}

void StageRunner::make(const StoredFunction* functions, int count, float* theta, ThetaRecord* records, ThetaTrace* trace) {
  for (int begin = 0; begin < count; begin += kBatchCount) {
    makeBatch(functions + begin, std::min(kBatchCount, count - begin), theta + begin * batch_.thetaCount(), records + begin,
              trace);
  }
}

void StageRunner::makeBatch(const StoredFunction* functions, int count, float* theta, ThetaRecord* records, ThetaTrace* trace) {
  const size_t value_count = count * batch_.thetaCount();
  const auto keepTrace = [&](std::vector<float> ThetaTrace::*word) {
    if (trace != nullptr) (trace->*word).insert((trace->*word).end(), theta, theta + value_count);
  };
  const FlushSubnormals flush;
  // one pass for all of the batch: each function is charged its share of the time
  const Clock::time_point start = Clock::now();
  batch_.generate(functions, count, theta, options_.use_generator != 0 ? ThetaBatch::Begin::network : ThetaBatch::Begin::theta0);
  const float network_us = microsecondsSince(start) / static_cast<float>(count);
  for (int i = 0; i < count; ++i) {
    records[i] = {};
    records[i].addTime(ThetaStage::network, ThetaWord::network, network_us);
  }
  keepTrace(&ThetaTrace::network);
  // only what the network left wrong takes part in the stages
  checkNetwork(functions, records);
  ThetaWord word = ThetaWord::corrected;
  // at the end of the corrections, and of the fits, a theta that passed and no longer would goes back
  for (Stage& stage : stages_) {
    if (word != wordOf(stage.plan.stage)) {
      finishWord(word, functions, records);
      keepTrace(&ThetaTrace::corrected);
      word = wordOf(stage.plan.stage);
    }
    runStage(stage, records);
  }
  finishWord(word, functions, records);
  // without a fit, fitted means what was corrected
  if (word == ThetaWord::corrected) {
    keepTrace(&ThetaTrace::corrected);
    for (int i = 0; i < count; ++i) records[i].at(ThetaWord::fitted) = records[i].at(ThetaWord::corrected);
  }
  keepTrace(&ThetaTrace::fitted);
  for (int i = 0; i < count; ++i) records[i].at(ThetaWord::stored) = records[i].at(ThetaWord::fitted);
}

void StageRunner::checkNetwork(const StoredFunction* functions, ThetaRecord* records) {
  wrong_.clear();
  for (int i = 0; i < batch_.count(); ++i) {
    const Clock::time_point start = Clock::now();
    const FunctionCheck check = checker_.check(batch_.representation(), functions[i], batch_.theta(i), options_.check());
    records[i].check.fill(check);
    if (!isGood(check, options_.good_rmse, options_.check())) {
      wrong_.push_back(i);
      std::copy_n(batch_.theta(i), batch_.thetaCount(), &kept_[i * batch_.thetaCount()]);
      kept_ended_[i] = ThetaStage::network;
    }
    records[i].addTime(ThetaStage::check, ThetaWord::corrected, microsecondsSince(start));
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
  const ThetaStage name = stage.plan.stage;
  if (isFit(name)) {
    for (int n = 0; n < member_count; ++n) records[members_[n]].took_fit = true;
  }
  stage.run->run(batch_, members_.data(), member_count);
  const float elapsed_us = microsecondsSince(start) / static_cast<float>(member_count);
  // a theta ends in the last stage that changed its loss
  for (const int i : wrong_) {
    if (!(before_[i] > above_square)) continue;
    records[i].addTime(name, wordOf(name), elapsed_us);
    if (batch_.meanSquare(i) != before_[i]) records[i].ended = name;
  }
}

void StageRunner::finishWord(ThetaWord word, const StoredFunction* functions, ThetaRecord* records) {
  const size_t D = batch_.thetaCount();
  const ThetaWord previous = static_cast<ThetaWord>(static_cast<int>(word) - 1);
  for (const int i : wrong_) {
    ThetaRecord& record = records[i];
    float* kept = &kept_[i * D];
    record.at(word) = record.at(previous);
    if (std::memcmp(kept, batch_.theta(i), D * sizeof(float)) == 0) continue;
    const Clock::time_point start = Clock::now();
    const FunctionCheck check = checker_.check(batch_.representation(), functions[i], batch_.theta(i), options_.check());
    // a lower loss may have a larger RMSE: what passed the check and would no longer stays as it was
    if (record.at(previous).passes(options_.check()) && !check.passes(options_.check())) {
      batch_.putBack(i, kept);
      record.ended = kept_ended_[i];
    } else {
      record.at(word) = check;
      std::copy_n(batch_.theta(i), D, kept);
      kept_ended_[i] = record.ended;
    }
    record.addTime(ThetaStage::check, word, microsecondsSince(start));
  }
}

}  // namespace nlg
