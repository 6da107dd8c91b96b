#include "tool/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "tests/input_error.h"
#include "tests/temporary_folder.h"
#include "tool/error.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

class AtomicFile : public testing::Test {
 protected:
  std::string at(const std::string& name) const { return folder_ / name; }
  size_t fileCount() const { return static_cast<size_t>(std::distance(fs::directory_iterator(folder_.string()), {})); }

  const TemporaryFolder folder_;
};

// Runs body in a child process, which must end with the code that body returns.
template <class Body>
int exitCodeOfChild(const Body& body) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(body());
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

// Mounts a disk of 64 kB on folder, for this process only; false where the system lets nobody do so.
bool mountTinyDisk(const std::string& folder) {
  const std::string user = std::to_string(::geteuid()), group = std::to_string(::getegid());
  if (::unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return false;
  // files on it need an owner that both sides of the new namespace know
  std::ofstream("/proc/self/setgroups") << "deny";
  std::ofstream("/proc/self/uid_map") << "0 " + user + " 1";
  std::ofstream("/proc/self/gid_map") << "0 " + group + " 1";
  return ::mount("none", folder.c_str(), "tmpfs", 0, "size=64k") == 0 && std::ofstream(folder + "/probe").is_open() &&
         ::unlink((folder + "/probe").c_str()) == 0;
}

// The message of the OutputError that write ends in.
template <class Write>
std::string outputErrorOf(const Write& write) {
  return errorOfCall<OutputError>(write);
}

TEST_F(AtomicFile, RoundTripsAnyBytes) {
  std::string bytes;
  for (int i = 0; i < 100000; ++i) bytes += static_cast<char>(i * 7 + i / 256);
  writeFileAtomically(at("data"), bytes);
  EXPECT_EQ(readFile(at("data")), bytes);
  EXPECT_EQ(fileSha256(at("data")), sha256(bytes));
  EXPECT_EQ(fileCount(), 1u);
}

// Libraries speak of the file that they were given: the user asked for another.
TEST_F(AtomicFile, NeverNamesTheTemporaryFile) {
  const auto failing = [&](const auto& error_of) {
    return outputErrorOf([&] { writeAtomically(at("data"), [&](const std::string& temporary) { throw error_of(temporary); }); });
  };
  EXPECT_EQ(failing([](const std::string& t) { return OutputError(t, "write failed: filename = " + t + ", errno = 28"); }),
            at("data") + ": cannot be written: write failed: filename = " + at("data") + ", errno = 28");
  EXPECT_EQ(failing([](const std::string& t) { return InputError(t, "read", "a readable file", "EIO"); }),
            at("data") + ": read: expected a readable file, got EIO");
  EXPECT_EQ(failing([](const std::string& t) { return std::runtime_error("stat " + t); }), "stat " + at("data"));
  EXPECT_THROW(writeAtomically(at("data"), [](const std::string&) { throw InputError("other.h5", "a", "b", "c"); }), InputError)
      << "what is of another file stays what it is";
  EXPECT_EQ(fileCount(), 0u);
}

TEST_F(AtomicFile, ReplacesTheOldFileWhole) {
  writeFileAtomically(at("data"), "a much longer old text");
  writeFileAtomically(at("data"), "new");
  EXPECT_EQ(readFile(at("data")), "new");
}

TEST_F(AtomicFile, NeverGivesTwoWritersOneTemporaryName) {
  std::string outer, inner;
  writeAtomically(at("data"), [&](const std::string& temporary_path) {
    outer = temporary_path;
    writeAtomically(at("data"), [&](const std::string& other_path) {
      inner = other_path;
      std::ofstream(other_path) << "inner";
    });
    std::ofstream(temporary_path) << "outer";
  });
  EXPECT_NE(outer, inner);
  EXPECT_NE(outer.find(std::to_string(::getpid())), std::string::npos) << outer;
  EXPECT_EQ(fs::path(outer).parent_path(), folder_.string());
  EXPECT_EQ(readFile(at("data")), "outer");
}

TEST_F(AtomicFile, LeavesTheOldFileAndNothingElseWhenTheWriterThrows) {
  writeFileAtomically(at("data"), "old");
  const auto write = [](const std::string& temporary_path) {
    std::ofstream(temporary_path) << "half";
    throw std::logic_error("unchanged");
  };
  try {
    writeAtomically(at("data"), write);
    FAIL() << "nothing thrown";
  } catch (const std::logic_error& error) {
    EXPECT_STREQ(error.what(), "unchanged");
  }
  EXPECT_EQ(readFile(at("data")), "old");
  EXPECT_EQ(fileCount(), 1u);
}

TEST_F(AtomicFile, LeavesTheOldFileWhenTheProcessDies) {
  writeFileAtomically(at("data"), "old");
  const int code = exitCodeOfChild([&] {
    writeAtomically(at("data"), [](const std::string& temporary_path) {
      std::ofstream(temporary_path) << "half" << std::flush;
      ::_exit(42);
    });
    return 0;
  });
  EXPECT_EQ(code, 42);
  EXPECT_EQ(readFile(at("data")), "old");
}

TEST_F(AtomicFile, SaysThatTheFolderIsNotWritable) {
  const std::string line = outputErrorOf([] { writeFileAtomically("/proc/nlg/data", "x"); });
  EXPECT_EQ(line.rfind("/proc/nlg/data: cannot be written: folder /proc/nlg: ", 0), 0u) << line;
  if (::geteuid() == 0) return;  // no folder is closed to root
  fs::permissions(folder_.string(), fs::perms::owner_read | fs::perms::owner_exec);
  const std::string denied = outputErrorOf([&] { writeFileAtomically(at("data"), "x"); });
  fs::permissions(folder_.string(), fs::perms::owner_all);
  EXPECT_NE(denied.find("Permission denied"), std::string::npos) << denied;
}

TEST_F(AtomicFile, IsNotWrittenOverALinkOrADevice) {
  writeFileAtomically(at("target"), "old");
  fs::create_symlink(at("target"), at("link"));
  EXPECT_NE(outputErrorOf([&] { writeFileAtomically(at("link"), "x"); }).find("not a regular file"), std::string::npos);
  EXPECT_TRUE(fs::is_symlink(at("link")));
  ASSERT_EQ(::mkfifo(at("pipe").c_str(), 0600), 0);  // stands for a device, which only root can make
  EXPECT_NE(outputErrorOf([&] { writeFileAtomically(at("pipe"), "x"); }).find("not a regular file"), std::string::npos);
  EXPECT_EQ(fileCount(), 3u);
}

TEST_F(AtomicFile, RemovesWhatDoesNotFit) {
  const int code = exitCodeOfChild([&] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1000, 1000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    const std::string line = outputErrorOf([&] { writeFileAtomically(at("data"), std::string(5000, 'x')); });
    return line.find("File too large") != std::string::npos ? 7 : 0;
  });
  EXPECT_EQ(code, 7);
  EXPECT_EQ(fileCount(), 0u);
}

TEST_F(AtomicFile, SaysThatTheDiskIsFull) {
  constexpr int kNoNamespaces = 77;
  const int code = exitCodeOfChild([&] {
    if (!mountTinyDisk(folder_.string())) return kNoNamespaces;
    const std::string line = outputErrorOf([&] { writeFileAtomically(at("data"), std::string(1 << 20, 'x')); });
    return line.find("the disk is full") != std::string::npos && fileCount() == 0 ? 7 : 0;
  });
  if (code == kNoNamespaces) GTEST_SKIP() << "this system lets nobody mount a small disk";
  EXPECT_EQ(code, 7);
}

TEST_F(AtomicFile, LeavesNothingWhenASignalEndsTheProcessInTheMiddle) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    std::ofstream(at("grid")) << "before";
    const auto writeAndEnd = [&] {
      removeTemporariesOnSignals();
      writeAtomically(at("grid"), [&](const std::string& temporary_path) {
        std::ofstream(temporary_path) << "half";
        if (fileCount() == 2) std::raise(signal);
      });
    };
    EXPECT_EXIT(writeAndEnd(), testing::KilledBySignal(signal), "");
    EXPECT_EQ(fileCount(), 1u) << signal;
    EXPECT_EQ(readFile(at("grid")), "before");
  }
}

}  // namespace
}  // namespace nlg
