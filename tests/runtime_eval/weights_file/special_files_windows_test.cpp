// What a system has besides files.
#include <gtest/gtest.h>
#include <windows.h>
#include <winioctl.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include "runtime_eval/weights_file/weights_file.h"

namespace nlg {
namespace {

// A pipe would keep the reader waiting for ever.
TEST(WeightsReader, OpensRegularFilesOnly) {
  const std::string path = "\\\\.\\pipe\\nlg_weights_" + std::to_string(::GetCurrentProcessId());
  const HANDLE pipe = ::CreateNamedPipeA(path.c_str(), PIPE_ACCESS_DUPLEX, PIPE_TYPE_BYTE | PIPE_WAIT, 1, 4096, 4096, 0, nullptr);
  ASSERT_NE(pipe, INVALID_HANDLE_VALUE);
  WeightsFile file;
  for (const auto& [name, what] : {std::pair<std::string, std::string>(path, "a pipe"),
                                   {std::filesystem::temp_directory_path().string(), "a directory"},
                                   {"NUL", "a device"}}) {
    const FileResult result = readWeightsFile(name, &file);
    EXPECT_EQ(result.status, FileStatus::cannot_open);
    EXPECT_EQ(result.detail, name + ": " + what);
  }
  ::CloseHandle(pipe);
}

TEST(WeightsReader, TakesNamesInUtf8) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / (L"nlg_\u00e4\u4e2d_" + std::to_wstring(::GetCurrentProcessId()));
  WeightsFile written, file;
  written.tensors["a"] = {{2}, {1.0f, 2.0f}};
  std::ofstream(path, std::ios::binary) << serializeWeights(written);
  const std::u8string name = path.u8string();
  const FileResult result = readWeightsFile(std::string(name.begin(), name.end()), &file);
  EXPECT_TRUE(result.ok()) << result.detail;
  EXPECT_EQ(file.tensors.size(), 1u);
  std::filesystem::remove(path);
  EXPECT_EQ(readWeightsFile("\xff.safetensors", &file).detail, "\xff.safetensors: its name is no UTF-8");
}

// A file of holes costs no disk, and must cost no memory.
TEST(WeightsReader, RefusesWhatIsTooLargeBeforeItTakesMemory) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("nlg_weights_holes_" + std::to_string(::GetCurrentProcessId()));
  const HANDLE holes = ::CreateFileW(path.c_str(), GENERIC_WRITE, 0, nullptr, CREATE_ALWAYS, FILE_ATTRIBUTE_NORMAL, nullptr);
  DWORD bytes = 0;
  ASSERT_TRUE(::DeviceIoControl(holes, FSCTL_SET_SPARSE, nullptr, 0, nullptr, 0, &bytes, nullptr));
  LARGE_INTEGER end;
  end.QuadPart = int64_t{1} << 40;
  ASSERT_TRUE(::SetFilePointerEx(holes, end, nullptr, FILE_BEGIN) && ::SetEndOfFile(holes));
  ::CloseHandle(holes);
  WeightsFile file;
  EXPECT_EQ(readWeightsFile(path.string(), &file).status, FileStatus::cannot_read);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace nlg
