#include "train/generator/lost_pages.h"

#include <unistd.h>

#include <csignal>

#include "tool/error.h"

namespace nlg {
namespace {

// made before the signal comes: a handler may neither allocate nor lock
std::string& lastLine() {
  static std::string line;
  return line;
}
const char* line_data = nullptr;
size_t line_count = 0;

void endProcess(int) {
  // nothing is left to do where not even that line can be written
  if (::write(STDERR_FILENO, line_data, line_count) < 0) ::_exit(static_cast<int>(ExitCode::internal_error));
  ::_exit(static_cast<int>(ExitCode::input_error));
}

}  // namespace

void endWhenPagesVanish(const std::string& tool, const std::string& path) {
  const InputError error(path, "mapped pages", "a file that stays as it is while it is read",
                         "one that was shortened, or a disk that failed");
  std::signal(SIGBUS, SIG_DFL);
  lastLine() = tool + ": error: " + error.what() + "\n";
  line_data = lastLine().data();
  line_count = lastLine().size();
  std::signal(SIGBUS, endProcess);
}

}  // namespace nlg
