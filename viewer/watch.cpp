#include "viewer/watch.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include "bake/again/check.h"
#include "bake/load_generators.h"
#include "tool/atomic_file.h"
#include "tool/command/tool_main.h"
#include "tool/error.h"
#include "tool/input_file.h"
#include "tool/output_path.h"
#include "tool/printable.h"
#include "viewer/child_process.h"

namespace nlg {
namespace {

// Watches files for changes.
//
// They are asked after, not listened to: what the kernel tells of a file (inotify) it does not tell of shared and network folders, and
// programs that save by renaming put another file in its place. Asking after some hundred files takes a millisecond.
class WatchedFiles {
 public:
  // Takes these files in place of the ones before, as they are now; of those that were watched already what is known of them stays.
  // since_ns   a new one that was written after this time counts as changed
  void watch(const std::vector<std::string>& paths, int64_t since_ns) {
    std::map<std::string, Stamp> stamps;
    for (const std::string& path : paths) {
      const auto known = stamps_.find(path);
      Stamp stamp = known != stamps_.end() ? known->second : stampOf(path);
      if (known == stamps_.end() && stamp.written_ns > since_ns) stamp = {};
      stamps[path] = stamp;
    }
    stamps_ = std::move(stamps);
  }

  // Whether any of them is another one than before, or has come or gone.
  bool haveChanged() const {
    return std::any_of(stamps_.begin(), stamps_.end(), [](const auto& one) { return stampOf(one.first) != one.second; });
  }
  // From here on they are what they are now.
  void accept() {
    for (auto& [path, stamp] : stamps_) stamp = stampOf(path);
  }

 private:
  struct Stamp {
    uint64_t device = 0, file = 0, bytes = 0;
    int64_t written_ns = -1;  // there is none
    bool operator==(const Stamp&) const = default;
  };
  // By when it came to be what it is here (ctime): a copy may keep the time of what it was made of.
  static Stamp stampOf(const std::string& path) {
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return {};
    return {status.st_dev, status.st_ino, static_cast<uint64_t>(status.st_size),
            int64_t{status.st_ctim.tv_sec} * 1'000'000'000 + status.st_ctim.tv_nsec};
  }

  std::map<std::string, Stamp> stamps_;
};

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

constexpr int kAskEveryMs = 250;
// of a preview
constexpr int kPreviewRays = 16, kPreviewPlaces = 4, kPreviewProbeRays = 64;

const OwnFiles kSettingsFiles = {"settings of a watch",
                                 [](std::string_view bytes) { return bytes.starts_with("{\n \"bake\": {"); }};

std::atomic<bool> is_stopped = false;  // by a signal, on any thread

int64_t nowNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::string lastLine(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text.substr(text.rfind('\n') + 1);
}

// Of one line, where it is one of progress.
std::optional<Stage> stageOfLine(const std::string& line) {
  const nlohmann::json said = nlohmann::json::parse(line, nullptr, false);
  if (!said.is_object() || !said.contains("stage")) return std::nullopt;
  Stage stage{said["stage"].get<std::string>(), {}};
  if (said.contains("of")) stage.share = said["done"].get<double>() / std::max(1.0, said["of"].get<double>());
  return stage;
}

class Watch {
 public:
  Watch(const ViewRequest& request, const BakeOptions& options, const OptionTable& table)
      : request_(request),
        options_(options),
        programs_(fs::read_symlink("/proc/self/exe").parent_path()),
        own_(fs::path(request.out) / "watch"),
        preview_((own_ / "preview.safetensors").string()),
        settings_((own_ / "settings.yaml").string()),
        inputs_((own_ / "inputs.json").string()),
        settings_text_(nlohmann::ordered_json{{"bake", table.toJson()}}.dump(1) + "\n"),  // JSON is YAML
        server_(request.port) {
    for (const auto& [path, own] :
         {std::pair(preview_, kGridFiles), std::pair(settings_, kSettingsFiles), std::pair(inputs_, kInputsFiles)})
      refuseToReplaceOthers(path, own);
    writeFileAtomically(settings_, settings_text_);
    files_.watch({request.scene}, nowNs());
  }

  void run() {
    std::cerr << "open " << server_.url() << '\n';
    while (!is_stopped) {
      if (bakeAndShow() != End::saved) {
        while (!is_stopped && !files_.haveChanged()) pause();
      }
      settle();
    }
  }

 private:
  enum class End { done, failed, saved, stopped };

  static void pause() { ::poll(nullptr, 0, kAskEveryMs); }

  // A program may write a file in several goes.
  void settle() {
    while (!is_stopped && files_.haveChanged()) {
      files_.accept();
      pause();
    }
  }

  void tell(const std::string& text, PageServer::Mood mood = PageServer::Mood::fine) {
    server_.tell(text, mood);
    std::cerr << "nlg-view: " << text << '\n';
  }

  // What is shown, and what goes on.
  void tellDoing(const std::string& doing) { tell((shown_.empty() ? "" : shown_ + "; ") + doing + " …", PageServer::Mood::busy); }

  // code   of its end; output: what it printed
  struct Ran {
    End end = End::done;
    int code = 0;
    std::string output, errors;
  };

  Ran runTool(const char* tool, Words words) {
    words.insert(words.begin(), {(programs_ / tool).string(), request_.scene});
    words.insert(words.end(), {"--config", settings_});
    // the folder may have been cleaned up
    if (std::error_code error; !fs::exists(settings_, error)) writeFileAtomically(settings_, settings_text_);
    ChildProcess child(words);
    while (child.isRunning(kAskEveryMs)) {
      if (is_stopped) return {End::stopped, 0, "", ""};
      if (files_.haveChanged()) return {End::saved, 0, "", ""};
      if (const std::optional<Stage> stage = stageOf(child.errors())) server_.tellStage(*stage);
    }
    return {End::done, child.exitCode(), child.output(), withoutProgress(child.errors())};
  }

  Ran runBake(Words words) {
    std::error_code gone;
    fs::remove(inputs_, gone);
    words.insert(words.end(), {"--inputs", inputs_});
    const int64_t since_ns = nowNs();
    Ran ran = runTool("nlg-bake", std::move(words));
    if (ran.end != End::done || !fs::exists(inputs_, gone)) return ran;
    std::vector<std::string> inputs = inputsOf(readFile(inputs_));
    inputs.push_back(request_.scene);
    files_.watch(inputs, since_ns);
    return ran;
  }

  // What became of a run that had to succeed; its error is told.
  End judge(const Ran& ran, const char* tool) {
    if (ran.end != End::done || ran.code == 0) return ran.end;
    std::string error = lastLine(ran.errors);
    if (ran.code < 0 || error.empty()) error = fmt::format("{}: error: ended by signal {}", tool, -ran.code);
    tell(error + (shown_.empty() ? "" : "; what is shown is from before") + "; waiting for the next save",
         PageServer::Mood::failed);
    return End::failed;
  }

  Words weights() const {
    if (request_.weights.empty()) return {};
    Words words = {"--weights"};
    words.insert(words.end(), request_.weights.begin(), request_.weights.end());
    return words;
  }

  // Weights that cannot be read are the bake's to name.
  bool canDraft() const {
    try {
      const Words& given = request_.weights;
      const LoadedGenerators loaded =
          loadGenerators(given.empty() ? shippedWeights(options_.representation, weightsFolders()) : given);
      return std::all_of(loaded.generators.begin(), loaded.generators.end(), [](const Generator& g) { return g.readsSamples(); });
    } catch (const ToolError&) {
      return false;
    }
  }

  // Nothing: nobody knows.
  Ran changesOf(std::optional<Words>* changes) {
    std::error_code error;
    if (!fs::exists(request_.grid, error)) return {};
    Words words = weights();
    words.insert(words.begin(), {"--check", request_.grid, "--json", "-"});
    Ran ran = runBake(words);
    const bool is_checked = ran.code == 0 || ran.code == static_cast<int>(ExitCode::check_failed);
    if (ran.end == End::done && is_checked) *changes = nlohmann::json::parse(ran.output).at("changes").get<Words>();
    if (ran.code == static_cast<int>(ExitCode::input_error)) tellDoing(lastLine(ran.errors) + "; it is made anew");
    return ran;
  }

  End show(const std::string& grid, bool is_last) {
    const auto number = [](int n) { return std::to_string(n); };
    Words words = {"--grid", grid, "--out", request_.out};
    words.insert(words.end(),
                 {"--baselines", is_last ? fmt::format("{}", fmt::join(request_.baselines, ",")) : "none", "--truth-views",
                  number(is_last ? request_.truth_views : 0), "--truth-samples", number(is_last ? request_.places : 0),
                  "--truth-width", number(request_.truth_width), "--truth-rays", number(request_.truth_rays)});
    const Ran ran = runTool("nlg-view", words);
    const End end = judge(ran, "nlg-view");
    if (end != End::done) return end;
    std::map<std::string, std::string> scripts;
    const nlohmann::json said = nlohmann::json::parse(ran.output);
    for (const auto& [name, bytes] : said.at("files").items()) scripts[name] = readFile((fs::path(request_.out) / name).string());
    server_.show(std::move(scripts));
    return end;
  }

  End bakeAndShow() {
    const auto start = std::chrono::steady_clock::now();
    tellDoing("looking for what has changed");
    std::optional<Words> changes;
    if (const Ran ran = changesOf(&changes); ran.end != End::done) return ran.end;
    const std::vector<GridBake> bakes = bakesAgain(changes, request_.grid, preview_, options_, canDraft());
    for (size_t i = 0; i < bakes.size(); ++i) {
      const GridBake& bake = bakes[i];
      tellDoing("baking: " + bake.name);
      Words words = bake.words;
      // functions that stay need no weights
      if (std::find(words.begin(), words.end(), "--relight") == words.end()) {
        const Words given = weights();
        words.insert(words.end(), given.begin(), given.end());
      }
      words.insert(words.end(), {"--out", bake.grid});
      const Ran baked = runBake(words);
      const bool is_last = i + 1 == bakes.size();
      if (is_last) std::cerr << baked.errors;
      if (const End end = judge(baked, "nlg-bake"); end != End::done) return end;
      if (const End end = show(bake.grid, is_last); end != End::done) return end;
      const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      shown_ = bake.name + ", after " + durationText(seconds);
    }
    if (bakes.empty()) {
      if (const End end = show(request_.grid, true); end != End::done) return end;
      shown_ = "final; nothing that it holds has changed";
    }
    tell(shown_);
    return End::done;
  }

  const ViewRequest& request_;
  const BakeOptions& options_;
  const fs::path programs_, own_;
  const std::string preview_, settings_, inputs_, settings_text_;
  PageServer server_;
  WatchedFiles files_;
  std::string shown_;  // what the page shows, in words
};

}  // namespace

std::vector<GridBake> bakesAgain(const std::optional<std::vector<std::string>>& changes, const std::string& grid,
                                 const std::string& preview, const BakeOptions& options, bool can_draft) {
  if (changes && changes->empty()) return {};
  const bool is_thinned = options.thin_error > 0.0 || options.max_bytes > 0.0;  // then only a grid that is not can be lit anew
  const auto isAll = [&](const char* change) { return changes == Words{change}; };
  const bool stay = !is_thinned && (isAll(kLightChanged) || isAll(kGroupsChanged));
  Words quick = stay ? Words{"--relight", grid} : Words{};
  if (is_thinned) quick.insert(quick.end(), {"--thin-error", "0", "--max-bytes", "0"});
  quick.insert(quick.end(), {"--light-rays",
                             std::to_string(std::min(options.light_rays > 0 ? options.light_rays : kPreviewRays, kPreviewRays)),
                             "--light-samples", std::to_string(std::min(options.light_samples, kPreviewPlaces)),
                             "--light-probe-rays", std::to_string(std::min(options.light_probe_rays, kPreviewProbeRays))});
  const bool is_draft = !stay && can_draft;
  if (is_draft) quick.push_back("--draft");
  return {{quick, preview, is_draft ? "draft" : "preview"}, {is_draft ? Words{} : Words{"--relight", preview}, grid, "final"}};
}

std::optional<Stage> stageOf(const std::string& said) {
  std::optional<Stage> stage;
  for (size_t end = said.rfind('\n'); !stage && end != std::string::npos && end > 0;) {
    const size_t before = said.rfind('\n', end - 1), begin = before == std::string::npos ? 0 : before + 1;
    stage = stageOfLine(said.substr(begin, end - begin));
    end = before;
  }
  return stage;
}

std::string withoutProgress(const std::string& said) {
  std::istringstream lines(said);
  std::string line, kept;
  while (std::getline(lines, line)) {
    if (!stageOfLine(line)) kept += line + '\n';
  }
  return kept;
}

void watchScene(ViewRequest request, const BakeOptions& options, const OptionTable& table) {
  if (request.out.empty()) request.out = folderOfView(request.scene);
  requireOutputFolder(request.out);
  if (request.grid.empty()) request.grid = (fs::path(request.out) / "grid.safetensors").string();
  refuseToReplace(request.grid, {request.scene}, kGridFiles, "--grid");
  refuseToReplaceOthersOf(request);
  ::setenv(kEndsWith, std::to_string(::getpid()).c_str(), 1);
  ::setenv("NLG_PROGRESS", "json", 1);  // of the tools that it starts
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, [](int) { is_stopped = true; });
  Watch(request, options, table).run();
}

}  // namespace nlg
