// Progress of a long loop on stderr: one line with the tool's name that rewrites itself, only when stderr is a terminal.
//
// The environment's NLG_PROGRESS=off keeps it quiet: where several tools share a terminal, their lines would overwrite each other.
// The workflow sets it (workflow/environment.sh) and says itself how far the run is.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace nlg {

class Progress {
 public:
  // what: "probes", "steps"; total: how many there will be
  Progress(std::string what, int64_t total);
  ~Progress();  // clears the line

  // The total as it is known by now, where it is only an estimate at first.
  void setTotal(int64_t total) { total_ = total; }
  // Whether update would print now: lets a fast loop save the making of its note.
  bool due() const;
  // Says how many are done; prints at most ten times a second: count, share, rate, time left, and note.
  void update(int64_t done, const std::string& note = "");

 private:
  std::string what_;
  int64_t total_;
  bool terminal_;
  bool printed_ = false;
  std::chrono::steady_clock::time_point start_, last_print_;
};

}  // namespace nlg
