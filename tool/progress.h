// Progress of a tool's stages on stderr. In a terminal one line with the tool's name, which rewrites itself; in a log a line for
// each stage that took a second or more, when it is over.
//
// The environment's NLG_PROGRESS=off keeps it quiet: where several tools share a terminal, their lines would overwrite each other.
// NLG_PROGRESS=json is for programs that start a tool and show how far it is: each time a line of JSON, {"stage": "probes", "done": 64,
// "of": 512}, without numbers for a stage that cannot be counted.
// NLG_PROGRESS=/FOLDER keeps that line in the file FOLDER/TOOL.PROCESS while the stage lasts: so does the workflow
// (workflow/Snakefile), which shows it in its own line.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace nlg {

class Progress {
 public:
  // what: "probes", "steps"; total: how many there will be, 0 where nobody knows
  explicit Progress(std::string what, int64_t total = 0);
  // Clears the line, or writes that of the log; not when an exception ends the stage.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // The total as it is known by now, where it is only an estimate at first.
  void setTotal(int64_t total) { total_ = total; }
  // So many were done before this stage began, which its rate must not count.
  void setDoneBefore(int64_t done) { done_before_ = done; }
  // Whether update would print now: lets a fast loop save the making of its note.
  bool due() const;
  // Says how many are done; prints at most ten times a second: count, share, rate, time left, and note. One thread at a time.
  void update(int64_t done, const std::string& note = "");
  // Says that so many more are done. Any thread may call it.
  void advance(int64_t count = 1);

 private:
  enum class Form { none, terminal, json, file, log };
  static Form wantedForm();
  bool isLive() const { return form_ != Form::none && form_ != Form::log; }
  static std::string file();
  void print(const std::string& line);

  std::string what_;
  int64_t total_, done_before_ = 0;
  Form form_;
  bool printed_ = false;
  int exceptions_;  // that were on their way when the stage began
  std::atomic<int64_t> advanced_{0};
  std::mutex printing_;
  std::chrono::steady_clock::time_point start_, last_print_;
};

}  // namespace nlg
