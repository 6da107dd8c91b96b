// Starts a program, reads its output, and ends it on demand.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace nlg {

class ChildProcess {
 public:
  // words   the program's path, and its arguments
  // throws  OutputError when the system starts none
  explicit ChildProcess(std::vector<std::string> words);
  // One that still runs is killed: what it writes is whole or not there.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // Waits until it says something or has ended, and no longer than wait_ms. False when it has ended, and all that it said is here.
  bool isRunning(int wait_ms);

  // What it said by now.
  const std::string& output() const { return pipes_[0].text; }
  const std::string& errors() const { return pipes_[1].text; }
  // Of one that has ended: its exit code; of one that was killed minus the signal.
  int exitCode() const { return exit_code_; }

 private:
  struct Pipe {
    int descriptor = -1;
    std::string text;
  };
  void read(Pipe* pipe);

  Pipe pipes_[2];  // stdout, stderr
  pid_t process_ = -1;
  int exit_code_ = 0;
};

}  // namespace nlg
