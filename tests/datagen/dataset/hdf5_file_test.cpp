#include "datagen/dataset/hdf5_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <limits>

#include "tests/input_error.h"
#include "tests/temporary_folder.h"
#include "tool/atomic_file.h"
#include "tool/error.h"

namespace nlg {
namespace {

class Hdf5File : public testing::Test {
 protected:
  template <class T>
  void writeOne(const std::vector<uint64_t>& shape, const std::vector<T>& values) const {
    Hdf5Writer file(path_);
    file.write("values", shape, values.data());
    file.close();
  }

  template <class T>
  void expectRoundTrip(const std::vector<uint64_t>& shape, const std::vector<T>& values) const {
    writeOne(shape, values);
    const Hdf5Reader file(path_);
    EXPECT_EQ(file.shape("values"), shape);
    EXPECT_EQ(file.read<T>("values", shape), values);
  }

  // The message that read is refused with.
  template <class Read>
  std::string refusal(const Read& read) const {
    return inputErrorOf([&] { read(Hdf5Reader(path_)); });
  }

  const TemporaryFolder folder_;
  const std::string path_ = folder_ / "file.h5";
};

template <class T>
std::vector<T> counted(size_t count) {
  std::vector<T> values(count);
  for (size_t i = 0; i < count; ++i) values[i] = static_cast<T>(i * 31 + i / 7);
  return values;
}

TEST_F(Hdf5File, RoundTripsEveryElementTypeAndChunking) {
  expectRoundTrip<uint8_t>({3, 5}, counted<uint8_t>(15));
  expectRoundTrip<uint32_t>({15}, counted<uint32_t>(15));
  expectRoundTrip<int32_t>({3}, {std::numeric_limits<int32_t>::min(), -1, std::numeric_limits<int32_t>::max()});
  expectRoundTrip<uint64_t>({2}, {0, std::numeric_limits<uint64_t>::max()});
  expectRoundTrip<float>({2, 1, 2}, {0.1f, -0.0f, std::numeric_limits<float>::infinity(), 1e-45f});
  expectRoundTrip<double>({1}, {0.1});
  // 256 kB a chunk: shapes around it, one row beyond it, and a single column
  expectRoundTrip<uint8_t>({33, 8192}, counted<uint8_t>(33 * 8192));
  expectRoundTrip<float>({3, 70000}, counted<float>(3 * 70000));
  expectRoundTrip<float>({65537}, counted<float>(65537));
  expectRoundTrip<double>({2, 3, 20000}, counted<double>(2 * 3 * 20000));
}

TEST_F(Hdf5File, RoundTripsAttributes) {
  const std::string large(100000, 'x');
  {
    Hdf5Writer file(path_);
    file.writeAttribute("text", std::string("é, two\nlines"));
    file.writeAttribute("nothing", std::string());
    file.writeAttribute("large", large);
    file.writeAttribute("number", std::numeric_limits<uint64_t>::max());
    file.close();
  }
  const Hdf5Reader file(path_);
  EXPECT_EQ(file.readTextAttribute("text"), "é, two\nlines");
  EXPECT_EQ(file.readTextAttribute("nothing"), "");
  EXPECT_EQ(file.readTextAttribute("large"), large);
  EXPECT_EQ(file.readIntegerAttribute("number"), std::numeric_limits<uint64_t>::max());
  EXPECT_THROW(file.readTextAttribute("missing"), InputError);
  EXPECT_THROW(file.readTextAttribute("number"), InputError);
  EXPECT_THROW(file.readIntegerAttribute("text"), InputError);
}

TEST_F(Hdf5File, GivesTheSameBytesASecondLater) {
  const auto write = [&] {
    Hdf5Writer file(path_);
    file.writeAttribute("a", uint64_t{5});
    file.write("values", {100, 100}, counted<float>(10000).data());
    file.close();
    return readFile(path_);
  };
  const std::string first = write();
  ::usleep(1100000);  // HDF5's own time stamps count seconds
  EXPECT_EQ(write(), first);
}

TEST_F(Hdf5File, RefusesAnotherShapeTypeOrName) {
  writeOne<float>({2, 3}, counted<float>(6));
  const auto refusalOfRead = [&](auto element, const std::string& name, const std::vector<uint64_t>& shape) {
    return refusal([&](const Hdf5Reader& file) { file.read<decltype(element)>(name, shape); });
  };
  EXPECT_EQ(refusalOfRead(0.0f, "values", {2, 3}), "no error");
  EXPECT_EQ(refusalOfRead(0.0f, "values", {3, 2}), path_ + ": dataset values: expected shape 3 x 2, got 2 x 3");
  EXPECT_EQ(refusalOfRead(0.0f, "values", {6}), path_ + ": dataset values: expected shape 6, got 2 x 3");
  EXPECT_EQ(refusalOfRead(0.0, "values", {2, 3}),
            path_ + ": dataset values: expected the element type of the format, got another type");
  EXPECT_EQ(refusalOfRead(int32_t{}, "values", {2, 3}),
            path_ + ": dataset values: expected the element type of the format, got another type");
  EXPECT_EQ(refusalOfRead(0.0f, "other", {2, 3}).rfind(path_ + ": dataset other: expected an array, got ", 0), 0u);
}

TEST_F(Hdf5File, EndsADiskThatRefusesAsOutputError) {
  const pid_t child = ::fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{20000, 20000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    std::vector<uint64_t> noise(10000);
    for (size_t i = 0; i < noise.size(); ++i) noise[i] = (i + 1) * 0x9e3779b97f4a7c15u;
    try {
      writeOne<uint64_t>({10000}, noise);
    } catch (const OutputError& error) {
      // with the handlers of a normal exit: HDF5's own would crash here
      std::exit(std::string(error.what()).find("File too large") != std::string::npos ? 7 : 8);
    }
    ::_exit(9);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 7);
  EXPECT_THROW(Hdf5Writer("/nowhere/x.h5"), OutputError);
}

}  // namespace
}  // namespace nlg
