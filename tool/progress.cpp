#include "tool/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <string_view>

#include <nlohmann/json.hpp>

#include "tool/printable.h"

namespace nlg {
namespace {

constexpr std::chrono::milliseconds kPrintInterval{100};
constexpr std::chrono::seconds kShortestLogged{1};

// A line longer than the terminal would wrap, and the next one could not rewrite it.
size_t terminalColumns() {
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col - 1u : 79u;
}

}  // namespace

Progress::Form Progress::wantedForm() {
  const char* const wish = std::getenv("NLG_PROGRESS");
  if (wish != nullptr && std::string_view(wish) == "off") return Form::none;
  if (wish != nullptr && std::string_view(wish) == "json") return Form::json;
  if (wish != nullptr && *wish == '/') return Form::file;
  return ::isatty(STDERR_FILENO) == 1 ? Form::terminal : Form::log;
}

Progress::Progress(std::string what, int64_t total)
    : what_(std::move(what)),
      total_(total),
      form_(wantedForm()),
      exceptions_(std::uncaught_exceptions()),
      start_(std::chrono::steady_clock::now()) {
  // what cannot be counted is named while it lasts
  if (total_ == 0 && form_ == Form::json)
    print(nlohmann::json{{"stage", what_}}.dump());
  else if (total_ == 0 && isLive())
    print(fmt::format("{}: {}", program_invocation_short_name, what_));
}

Progress::~Progress() {
  if (printed_ && form_ == Form::file) ::unlink(file().c_str());
  if (printed_ && form_ == Form::terminal) std::fputs("\r\033[K", stderr);
  const auto took = std::chrono::steady_clock::now() - start_;
  if (form_ != Form::log || took < kShortestLogged || std::uncaught_exceptions() > exceptions_) return;
  const std::string line = fmt::format("{}: {}: {}\n", program_invocation_short_name, what_,
                                       durationText(std::chrono::duration<double>(took).count()));
  std::fputs(line.c_str(), stderr);
}

bool Progress::due() const { return isLive() && (!printed_ || std::chrono::steady_clock::now() - last_print_ >= kPrintInterval); }

void Progress::advance(int64_t count) {
  const int64_t done = advanced_ += count;
  // who finds another one printing has nothing newer to say
  const std::unique_lock lock(printing_, std::try_to_lock);
  if (lock.owns_lock()) update(done);
}

std::string Progress::file() {
  return fmt::format("{}/{}.{}", std::getenv("NLG_PROGRESS"), program_invocation_short_name, ::getpid());
}

void Progress::print(const std::string& line) {
  const std::string printed = form_ == Form::json ? line + '\n' : "\r\033[K" + line.substr(0, terminalColumns());
  if (form_ == Form::file) {
    std::ofstream(file()) << line << '\n';
  } else {
    std::fputs(printed.c_str(), stderr);
    std::fflush(stderr);
  }
  last_print_ = std::chrono::steady_clock::now();
  printed_ = true;
}

void Progress::update(int64_t done, const std::string& note) {
  if (!due()) return;
  if (form_ == Form::json) return print(nlohmann::json{{"stage", what_}, {"done", done}, {"of", total_}}.dump());
  const auto now = std::chrono::steady_clock::now();
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  const double rate = elapsed_s > 0 ? static_cast<double>(done - done_before_) / elapsed_s : 0;
  std::string line = fmt::format("{}: {}: {} of {}", program_invocation_short_name, what_, done, total_);
  if (total_ > 0) line += fmt::format(" ({:.1f} %)", 100.0 * static_cast<double>(done) / static_cast<double>(total_));
  if (rate > 0) {
    line += fmt::format(", {:.4g}/s, {} left", rate, durationText(static_cast<double>(total_ - done) / rate));
  }
  if (!note.empty()) line += ", " + note;
  print(line);
}

}  // namespace nlg
