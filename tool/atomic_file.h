// Writes files atomically: whole, or not at all.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace nlg {

// Calls write(temporary_path), flushes the file to the disk, and renames it to path; makes the folder if it is missing.
// The temporary name lies in the same folder and holds the process id, so that two writers never share one. When write throws,
// or the process dies, path is what it was before; a temporary file of ours is removed when write throws, and one that a process
// which died left behind when the same machine next writes to path.
// throws   OutputError with the system's reason (folder not writable, disk full; path is a device, a link or a folder); whatever
// write throws, unchanged, unless it names the temporary file: then an OutputError in the same words about path
void writeAtomically(const std::string& path, const std::function<void(const std::string& temporary_path)>& write);

// From here on SIGINT (Ctrl-C), SIGTERM and SIGHUP, where they end the process, remove the temporary files of its writers first.
void removeTemporariesOnSignals();

// The same for a text or bytes that are already in memory.
void writeFileAtomically(const std::string& path, std::string_view bytes);

// The whole of a regular file.
// throws   InputError when it cannot be opened or read, is something else, or is larger than max_bytes
std::string readFile(const std::string& path, size_t max_bytes = size_t{1} << 32);

// SHA-256 of a file's bytes, 64 lower-case hexadecimal digits.
// throws   InputError when it cannot be read
std::string fileSha256(const std::string& path);

// The same, raw (32 bytes), of the file with the bytes of one range taken as zeros: a file may hold its own hash there.
struct ByteRange {
  uint64_t first = 0, count = 0;
};
std::vector<uint8_t> fileSha256Bytes(const std::string& path, ByteRange zeroed);

// SHA-256 of bytes in memory.
std::string sha256(std::string_view bytes);

}  // namespace nlg
