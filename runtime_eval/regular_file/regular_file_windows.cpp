#include <fcntl.h>
#include <io.h>
#include <sys/stat.h>
#include <windows.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "runtime_eval/regular_file/regular_file.h"

namespace nlg {
namespace {

std::string reasonOf(int error_number) { return std::generic_category().message(error_number); }

// Empty where the text is no UTF-8.
std::wstring wideOf(const std::string& utf8) {
  const int bytes = static_cast<int>(utf8.size());
  std::wstring wide(static_cast<size_t>(::MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, utf8.data(), bytes, nullptr, 0)),
                    L'\0');
  ::MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, utf8.data(), bytes, wide.data(), static_cast<int>(wide.size()));
  return wide;
}

HANDLE handleOf(int file) { return reinterpret_cast<HANDLE>(::_get_osfhandle(file)); }

}  // namespace

int openRegularFile(const std::string& path, std::string* fault) {
  const std::wstring wide = wideOf(path);
  if (wide.empty() && !path.empty()) {
    *fault = "its name is no UTF-8";
    return -1;
  }
  const int file = ::_wopen(wide.c_str(), _O_RDONLY | _O_BINARY | _O_NOINHERIT);
  if (file < 0) {
    // a directory is not opened, and the reason is that of a file which may not be read
    const int reason = errno;
    const DWORD attributes = ::GetFileAttributesW(wide.c_str());
    const bool is_directory = attributes != INVALID_FILE_ATTRIBUTES && (attributes & FILE_ATTRIBUTE_DIRECTORY) != 0;
    *fault = is_directory ? "a directory" : reasonOf(reason);
    return -1;
  }
  // only what is on a disk is a regular file
  switch (::GetFileType(handleOf(file))) {
    case FILE_TYPE_DISK:
      return file;
    case FILE_TYPE_PIPE:
      *fault = "a pipe";
      break;
    case FILE_TYPE_CHAR:
      *fault = "a device";
      break;
    default:
      *fault = "something else";
  }
  ::_close(file);
  return -1;
}

void closeRegularFile(int file) { ::_close(file); }

int64_t regularFileSize(int file) { return ::_filelengthi64(file); }

bool readRegularFile(int file, uint64_t offset, void* to, size_t count) {
  char* at = static_cast<char*>(to);
  while (count > 0) {
    OVERLAPPED place{};
    place.Offset = static_cast<DWORD>(offset);
    place.OffsetHigh = static_cast<DWORD>(offset >> 32);
    DWORD more = 0;
    const DWORD wanted = static_cast<DWORD>(std::min<size_t>(count, size_t{1} << 30));
    if (::ReadFile(handleOf(file), at, wanted, &more, &place) == 0 || more == 0) return false;
    at += more;
    offset += more;
    count -= more;
  }
  return true;
}

}  // namespace nlg
