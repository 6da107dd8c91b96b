#include "scene/gltf_file.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

#include "scene/gltf_accessor.h"
#include "scene/gltf_draco.h"
#include "scene/gltf_json.h"
#include "scene/gltf_meshopt.h"
#include "scene/scene_file.h"
#include "tool/error.h"
#include "tool/input_file.h"

namespace nlg {
namespace {

using Bytes = std::vector<unsigned char>;

bool isBinary(const Bytes& bytes) { return bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0; }

uint32_t wordAt(const Bytes& bytes, size_t offset) { return readUnsigned(bytes.data() + offset, 4); }

// The JSON chunk of a .glb. tinygltf 2.7 lets the binary chunk reach eight bytes past the end, so chunks are checked here.
std::string_view binaryText(const std::string& path, const Bytes& bytes) {
  const auto require = [&](bool holds, const std::string& place, const std::string& expected, uint64_t got) {
    if (!holds) throw InputError(path, place, expected, std::to_string(got));
  };
  require(bytes.size() >= 20, "header", "20 bytes or more", bytes.size());
  require(wordAt(bytes, 4) == 2, "header", "version 2", wordAt(bytes, 4));
  const uint64_t length = wordAt(bytes, 8);
  require(length == bytes.size(), "header", "a length equal to the file's " + std::to_string(bytes.size()), length);
  constexpr uint32_t kJson = 0x4E4F534A;
  constexpr uint32_t kBin = 0x004E4942;
  const uint64_t json_length = wordAt(bytes, 12);
  require(wordAt(bytes, 16) == kJson, "first chunk", "JSON", wordAt(bytes, 16));
  require(json_length <= length - 20, "first chunk", "a length within the file", json_length);
  require(json_length % 4 == 0, "first chunk", "a length that is a multiple of 4", json_length);
  const uint64_t next = 20 + json_length;
  if (next < length) {
    require(length - next >= 8, "second chunk", "a header of 8 bytes", length - next);
    require(wordAt(bytes, next + 4) == kBin, "second chunk", "BIN", wordAt(bytes, next + 4));
    require(wordAt(bytes, next) <= length - next - 8, "second chunk", "a length within the file", wordAt(bytes, next));
  }
  return {reinterpret_cast<const char*>(bytes.data()) + 20, json_length};
}

void appendWord(Bytes& bytes, uint64_t word) {
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<unsigned char>(word >> (8 * i)));
}

// The .glb with another JSON chunk; binaryText has found it whole.
Bytes withText(const std::string& path, const Bytes& bytes, std::string text) {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const size_t next = 20 + static_cast<size_t>(wordAt(bytes, 12));
  const uint64_t length = 20 + text.size() + (bytes.size() - next);
  if (length > kMaxSceneBytes) throw InputError(path, "file", "less than 4 GiB", std::to_string(length));
  Bytes result(bytes.begin(), bytes.begin() + 8);
  appendWord(result, length);
  appendWord(result, text.size());
  result.insert(result.end(), bytes.begin() + 16, bytes.begin() + 20);
  result.insert(result.end(), text.begin(), text.end());
  result.insert(result.end(), bytes.begin() + static_cast<std::ptrdiff_t>(next), bytes.end());
  return result;
}

// The files of buffers, in the order in which tinygltf asks for them, by whatever name: it decodes addresses otherwise. It may open no
// other.
struct BufferFiles {
  std::vector<std::string> paths;
  size_t next;
  SceneBudget* bytes_left;
};

BufferFiles findBuffers(const std::string& path, const std::vector<std::string>& addresses, SceneBudget& bytes_left) {
  BufferFiles files{{}, 0, &bytes_left};
  // what all of them hold is known before the first is read
  SceneBudget all = bytes_left;
  for (const std::string& address : addresses) {
    const std::string place = "buffer \"" + address.substr(0, 80) + "\"";
    const FileBeside file = findBeside(path, address);
    if (file.path.empty()) throw InputError(path, place, "a file in the folder or below", "one that " + file.problem);
    all.take(InputFile(file.path, place).size(), path, place);
    files.paths.push_back(file.path);
  }
  return files;
}

bool fileExists(const std::string&, void* user) {
  const BufferFiles& files = *static_cast<BufferFiles*>(user);
  return files.next < files.paths.size();
}

std::string samePath(const std::string& path, void*) { return path; }

bool readWholeFile(Bytes* bytes, std::string*, const std::string&, void* user) {
  BufferFiles& files = *static_cast<BufferFiles*>(user);
  *bytes = readSceneFile(files.paths.at(files.next++), "buffer", *files.bytes_left);
  return true;
}

bool writeNothing(std::string*, const std::string&, const Bytes&, void*) { return false; }

// Keeps what a data URI holds, as it is; all other bytes lie where they will be found.
bool keepPacked(tinygltf::Image* image, const int, std::string*, std::string*, int, int, const unsigned char* bytes, int size,
                void*) {
  if (image->bufferView < 0 && image->uri.empty()) image->image.assign(bytes, bytes + size);
  return true;
}

// tinygltf's words as part of one line.
std::string oneLine(std::string words) {
  std::replace(words.begin(), words.end(), '\n', ' ');
  return words.empty() ? "something else" : words.substr(0, 200);
}

}  // namespace

tinygltf::Model loadGltfFile(const std::string& path, SceneBudget& bytes_left) {
  Bytes bytes = readSceneFile(path, "file", bytes_left);
  if (bytes.empty()) throw InputError(path, "file", "glTF", "an empty file");
  const bool is_binary = isBinary(bytes);
  const std::string_view text =
      is_binary ? binaryText(path, bytes) : std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  GltfJson json = readGltfJson(path, text, is_binary);
  BufferFiles files = findBuffers(path, json.buffer_files, bytes_left);
  if (!json.plain_text.empty())
    bytes = is_binary ? withText(path, bytes, std::move(json.plain_text)) : Bytes(json.plain_text.begin(), json.plain_text.end());

  const std::string folder = folderOf(path);
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(keepPacked, nullptr);
  loader.SetFsCallbacks({fileExists, samePath, readWholeFile, writeNothing, &files});
  tinygltf::Model model;
  std::string error;
  std::string warning;
  bool is_loaded = false;
  try {
    const auto size = static_cast<unsigned int>(bytes.size());
    is_loaded = is_binary ? loader.LoadBinaryFromMemory(&model, &error, &warning, bytes.data(), size, folder)
                          : loader.LoadASCIIFromString(&model, &error, &warning, reinterpret_cast<const char*>(bytes.data()),
                                                       size, folder);
  } catch (const ToolError&) {
    throw;
  } catch (const std::exception& exception) {
    error = exception.what();  // of the JSON library and of containers
  }
  if (!is_loaded) throw InputError(path, "file", "glTF 2.0", oneLine(error));
  unpackMeshopt(path, model, bytes_left);
  unpackDraco(path, model, bytes_left);
  return model;
}

}  // namespace nlg
