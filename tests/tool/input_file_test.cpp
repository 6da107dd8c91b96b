#include "tool/input_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "tests/input_error.h"
#include "tests/temporary_folder.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

namespace fs = std::filesystem;

class InputFileTest : public testing::Test {
 protected:
  InputFileTest() { folder_.write("whole", "0123456789"); }

  std::string at(const std::string& name) const { return folder_ / name; }

  // The line of the InputError that opening the path gives.
  static std::string errorOf(const std::string& path) {
    return inputErrorOf([&] { InputFile(path, "the place"); });
  }
  static void expectError(const std::string& path, const std::string& got) {
    EXPECT_EQ(errorOf(path), path + ": the place: expected a regular file, got " + got);
  }

  const TemporaryFolder folder_;
};

TEST_F(InputFileTest, ReadsOnAndAtAnyOffset) {
  InputFile file(at("whole"));
  EXPECT_EQ(file.size(), 10u);
  std::string bytes(4, ' ');
  EXPECT_EQ(file.read(bytes.data(), 4), 4u);
  EXPECT_EQ(bytes, "0123");
  EXPECT_EQ(file.readAt(8, bytes.data(), 4), 2u);
  EXPECT_EQ(bytes, "8923");
  EXPECT_EQ(file.read(bytes.data(), 4), 4u);
  EXPECT_EQ(bytes, "4567");
  EXPECT_EQ(file.read(bytes.data(), 4), 2u);
  EXPECT_EQ(file.read(bytes.data(), 4), 0u);
}

TEST_F(InputFileTest, FollowsLinksToRegularFiles) {
  fs::create_symlink("whole", at("link"));
  fs::create_symlink("link", at("link of a link"));
  EXPECT_EQ(readFile(at("link of a link")), "0123456789");
}

// Each of them would keep a reader waiting, or never end: were it opened as files are, this test would not end either.
TEST_F(InputFileTest, RefusesAtOnceWhatIsNoRegularFileAndSaysWhatItIs) {
  ASSERT_EQ(::mkfifo(at("pipe").c_str(), 0600), 0);
  fs::create_symlink("pipe", at("link to a pipe"));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, at("socket").c_str(), sizeof address.sun_path - 1);
  const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0) << at("socket");
  expectError(at("pipe"), "a pipe");
  expectError(at("link to a pipe"), "a pipe");
  expectError(at("socket"), "a socket");
  expectError(folder_.string(), "a directory");
  expectError("/dev/zero", "a device");
  ::close(socket);
  EXPECT_THROW(readFile(at("pipe")), InputError);
  EXPECT_THROW(fileSha256("/dev/zero"), InputError);
}

TEST_F(InputFileTest, GivesTheSystemsReason) {
  fs::create_symlink("ring", at("ring"));
  expectError(at("ring"), "Too many levels of symbolic links");
  EXPECT_EQ(errorOf(at("missing")), at("missing") + ": the place: expected a file, got none: there is no file of this name");
  expectError(at(std::string(300, 'x')), "File name too long");
  expectError(at("whole/inner"), "Not a directory");
}

// A reader that does not wait may get half of what it asks for, on some network file systems.
TEST_F(InputFileTest, WaitsForItsBytesOnceItIsOpen) {
  const InputFile file(at("whole"));
  EXPECT_EQ(::fcntl(file.descriptor(), F_GETFL) & O_NONBLOCK, 0);
}

TEST_F(InputFileTest, AReaderOfFilesTellsHowManyBytesAreTooMany) {
  EXPECT_EQ(inputErrorOf([&] { readFile(at("whole"), 9); }), at("whole") + ": size: expected at most 9 bytes, got 10 or more");
}

}  // namespace
}  // namespace nlg
