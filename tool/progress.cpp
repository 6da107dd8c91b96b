#include "tool/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace nlg {
namespace {

constexpr std::chrono::milliseconds kPrintInterval{100};

// A line longer than the terminal would wrap, and the next one could not rewrite it.
size_t terminalColumns() {
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col - 1u : 79u;
}

std::string duration(double seconds) {
  const auto whole = static_cast<int64_t>(std::clamp(seconds, 0.0, 1e9));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

bool isWanted() {
  const char* const wish = std::getenv("NLG_PROGRESS");
  return (wish == nullptr || std::string_view(wish) != "off") && ::isatty(STDERR_FILENO) == 1;
}

}  // namespace

Progress::Progress(std::string what, int64_t total)
    : what_(std::move(what)), total_(total), terminal_(isWanted()), start_(std::chrono::steady_clock::now()) {}

Progress::~Progress() {
  if (printed_) std::fputs("\r\033[K", stderr);
}

bool Progress::due() const {
  return terminal_ && (!printed_ || std::chrono::steady_clock::now() - last_print_ >= kPrintInterval);
}

void Progress::update(int64_t done, const std::string& note) {
  if (!due()) return;
  const auto now = std::chrono::steady_clock::now();
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  const double rate = elapsed_s > 0 ? static_cast<double>(done) / elapsed_s : 0;
  std::string line = fmt::format("{}: {}: {} of {}", program_invocation_short_name, what_, done, total_);
  if (total_ > 0) line += fmt::format(" ({:.1f} %)", 100.0 * static_cast<double>(done) / static_cast<double>(total_));
  if (rate > 0) {
    line += fmt::format(", {:.4g}/s, {} left", rate, duration(static_cast<double>(total_ - done) / rate));
  }
  if (!note.empty()) line += ", " + note;
  line.resize(std::min(line.size(), terminalColumns()));
  std::fputs(("\r\033[K" + line).c_str(), stderr);
  std::fflush(stderr);
  last_print_ = now;
  printed_ = true;
}

}  // namespace nlg
