#include "viewer/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <system_error>

#include "tool/error.h"

namespace nlg {

ChildProcess::ChildProcess(std::vector<std::string> words) {
  std::vector<char*> arguments(words.size() + 1);  // the last is none
  for (size_t i = 0; i < words.size(); ++i) arguments[i] = words[i].data();
  std::array<std::array<int, 2>, 2> ends{};
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  int error = 0;
  for (int i = 0; i < 2; ++i) {
    if (::pipe2(ends[i].data(), O_CLOEXEC) != 0) error = errno;
    pipes_[i].descriptor = ends[i][0];
    ::posix_spawn_file_actions_adddup2(&actions, ends[i][1], i + 1);
  }
  if (error == 0) error = ::posix_spawn(&process_, arguments[0], &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  for (const std::array<int, 2>& end : ends) ::close(end[1]);
  if (error == 0) return;
  process_ = -1;
  for (const Pipe& pipe : pipes_) ::close(pipe.descriptor);
  throw OutputError(words[0] + ": cannot be started: " + std::generic_category().message(error));
}

ChildProcess::~ChildProcess() {
  if (process_ > 0) {
    ::kill(process_, SIGKILL);
    while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  for (const Pipe& pipe : pipes_) {
    if (pipe.descriptor >= 0) ::close(pipe.descriptor);
  }
}

void ChildProcess::read(Pipe* pipe) {
  std::array<char, 4096> block;
  const ssize_t count = ::read(pipe->descriptor, block.data(), block.size());
  if (count > 0) pipe->text.append(block.data(), static_cast<size_t>(count));
  if (count > 0 || (count < 0 && errno == EINTR)) return;
  ::close(pipe->descriptor);
  pipe->descriptor = -1;
}

bool ChildProcess::isRunning(int wait_ms) {
  if (process_ < 0) return false;
  std::array<pollfd, 2> polled = {pollfd{pipes_[0].descriptor, POLLIN, 0}, pollfd{pipes_[1].descriptor, POLLIN, 0}};
  // a descriptor below 0 is passed over
  if (::poll(polled.data(), polled.size(), wait_ms) > 0) {
    for (int i = 0; i < 2; ++i) {
      if (polled[i].revents != 0) read(&pipes_[i]);
    }
  }
  if (pipes_[0].descriptor >= 0 || pipes_[1].descriptor >= 0) return true;
  int status = 0;
  while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  return false;
}

}  // namespace nlg
