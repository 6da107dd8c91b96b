// Errors that a user can act on, and the exit code of each.
//
// Two families, never mixed. A wrong file, setting or number is an exception of this header: only `runTool` (tool_main.h)
// catches it, prints one line on stderr and exits with the documented code. A broken promise of our own code is
// NLG_CHECK, which prints the expression with both values and aborts; it never judges input.
#pragma once

#include <cstdlib>
#include <iostream>
#include <stdexcept>
#include <string>

namespace nlg {

// Exit codes of every tool; also listed in docs/reference/formats.md.
enum class ExitCode : int {
  success = 0,
  internal_error = 1,   // a bug of ours, or a machine that gives no more memory or threads
  usage_error = 2,      // command line or pipeline.yaml
  input_error = 3,      // a file that cannot be used
  numerical_error = 4,  // NaN, divergence; the last good state has been saved
  output_error = 5,     // a file that cannot be written; nothing half-written is left behind
  check_failed = 6,     // a comparison that the tool makes by itself did not hold (export parity)
  damaged_file = 7,     // `info`: a file whose own bytes prove damage; it may be made again
};

// Base of the errors below: what() is the one line that the user sees.
class ToolError : public std::runtime_error {
 public:
  ToolError(ExitCode exit_code, const std::string& line) : std::runtime_error(line), exit_code_(exit_code) {}
  ExitCode exitCode() const { return exit_code_; }

 private:
  ExitCode exit_code_;
};

// A command line or setting that cannot be used.
// place      file with line and column, or the flag: "pipeline.yaml:12:3", "--jitter"
// expected   what would have been right; got: what stood there
// line       all of it, where options conflict: "--check cannot be combined with --out: nothing is baked"
class UsageError : public ToolError {
 public:
  UsageError(const std::string& place, const std::string& expected, const std::string& got)
      : ToolError(ExitCode::usage_error, place + ": expected " + expected + ", got " + got) {}
  explicit UsageError(const std::string& line) : ToolError(ExitCode::usage_error, line) {}
};

// A file that is missing, damaged, hostile, or belongs to something else.
// path       the file; place: where in it ("mesh 3, primitive 0: POSITION", "dataset phi", "byte 17")
// problem    what is wrong, where no one value is at fault: "has no provenance; bake the grid again"
class InputError : public ToolError {
 public:
  InputError(const std::string& path, const std::string& place, const std::string& expected, const std::string& got)
      : ToolError(ExitCode::input_error,
                  (path.empty() ? "\"\"" : path) + ": " + place + ": expected " + expected + ", got " + got) {}
  InputError(const std::string& path, const std::string& problem) : ToolError(ExitCode::input_error, path + ": " + problem) {}
};

// An input file whose own bytes prove that it is damaged: cut short, a checksum that does not hold. What the system refused to
// open or to read proves nothing, and is an InputError. Tools that only read the file end as they do for any other InputError.
class DamageError : public InputError {
 public:
  using InputError::InputError;
};

// Numbers that went wrong: names stage, step, quantity and value.
class NumericalError : public ToolError {
 public:
  NumericalError(const std::string& stage, const std::string& step, const std::string& quantity, double value)
      : ToolError(ExitCode::numerical_error, stage + ": " + step + ": " + quantity + " is " + std::to_string(value)) {}
  // line   all of it: where no one value is at fault
  explicit NumericalError(const std::string& line) : ToolError(ExitCode::numerical_error, line) {}
};

// A file that could not be written. reason: the system's words.
class OutputError : public ToolError {
 public:
  OutputError(const std::string& path, const std::string& reason)
      : ToolError(ExitCode::output_error, path + ": cannot be written: " + reason) {}
  // line   all of it: where another one is told in other words
  explicit OutputError(const std::string& line) : ToolError(ExitCode::output_error, line) {}
};

// Threads that the system refused to make, by a limit on processes or for want of memory. Like memory that runs out it says nothing of
// the user's files or settings, and ends a tool with the same code.
// made       how many of `wanted` there were before; reason: the system's words
class ThreadError : public ToolError {
 public:
  ThreadError(int made, int wanted, const std::string& reason)
      : ToolError(ExitCode::internal_error, "threads: expected " + std::to_string(wanted) + " more, got " + std::to_string(made) +
                                                ": " + reason + "; raise ulimit -u, or the container's limit on processes") {}
};

// What an InputError got where its path leads to nothing.
inline constexpr const char* kNoSuchFile = "none: there is no file of this name";

// A check that a tool makes of its own result and that did not hold.
class CheckFailed : public ToolError {
 public:
  CheckFailed(const std::string& check, const std::string& expected, const std::string& got)
      : ToolError(ExitCode::check_failed, check + ": expected " + expected + ", got " + got) {}
};

namespace detail {
template <class A, class B>
[[noreturn]] void checkFailed(const char* file, int line, const char* expression, const A& a, const B& b) {
  std::cerr << file << ':' << line << ": check failed: " << expression << " (" << a << " against " << b << ")\n";
  std::abort();
}
}  // namespace detail

}  // namespace nlg

// Aborts with both values when `a op b` does not hold: for our own promises, never for input.
#define NLG_CHECK(a, op, b)                                                                            \
  do {                                                                                                 \
    if (!((a)op(b))) ::nlg::detail::checkFailed(__FILE_NAME__, __LINE__, #a " " #op " " #b, (a), (b)); \
  } while (false)
