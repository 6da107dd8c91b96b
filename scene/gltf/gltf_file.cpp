#include "scene/gltf/gltf_file.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "scene/archive/scene_file.h"
#include "scene/gltf/gltf_accessor.h"
#include "scene/gltf/gltf_json.h"
#include "scene/gltf/gltf_packed.h"
#include "tool/error.h"
#include "tool/input_file.h"

namespace nlg {
namespace {

using Bytes = std::vector<unsigned char>;

bool isBinary(const Bytes& bytes) { return bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0; }

uint32_t wordAt(const Bytes& bytes, size_t offset) { return readUnsigned(bytes.data() + offset, 4); }

struct GlbChunks {
  std::string_view text, bin;
  bool is_plain = false;  // just these two, as tinygltf wants them
};

// tinygltf 2.7 lets the binary chunk reach eight bytes past the end, and takes no others: chunks are sorted out here.
GlbChunks chunksOf(const std::string& path, const Bytes& bytes, Oddities* odd) {
  const auto require = [&](bool holds, const std::string& place, const std::string& expected, uint64_t got) {
    if (!holds) throw InputError(path, place, expected, std::to_string(got));
  };
  // a .glb has 12 bytes of header and 8 before each chunk: magic, version, length; length, kind
  require(bytes.size() >= 20, "header", "20 bytes or more", bytes.size());
  require(wordAt(bytes, 4) == 2, "header", "version 2", wordAt(bytes, 4));
  constexpr uint32_t kJson = 0x4E4F534A;
  constexpr uint32_t kBin = 0x004E4942;
  require(wordAt(bytes, 16) == kJson, "first chunk", "JSON", wordAt(bytes, 16));
  // the header's length is not believed: the file's is what can be read
  const uint64_t length = wordAt(bytes, 8);
  if (length != bytes.size())
    odd->add("passed by", fmt::format("a header that says {} bytes of a file of {}", length, bytes.size()));
  GlbChunks chunks;
  size_t others = 0, at = 12;
  // JSON first, one BIN after it at most; others must be skipped (glTF 2.0, 4.4.3)
  for (uint64_t size = 0; at + 8 <= bytes.size(); at += 8 + size) {
    size = wordAt(bytes, at);
    const uint32_t kind = wordAt(bytes, at + 4);
    const bool is_text = at == 12, is_bin = kind == kBin && chunks.bin.data() == nullptr;
    const bool fits = size <= bytes.size() - at - 8;
    if (is_text || is_bin) require(fits, is_text ? "first chunk" : "binary chunk", "a length within the file", size);
    if (!fits) break;
    const std::string_view chunk(reinterpret_cast<const char*>(bytes.data()) + at + 8, size);
    if (is_text) chunks.text = chunk;
    if (is_bin) chunks.bin = chunk;
    if (!is_text && !is_bin) ++others;
  }
  // what is skipped is reported: it may hold what the user misses
  if (others > 0) odd->add("passed by", counted(others, "chunk", "chunks") + " of an unknown kind");
  if (at < bytes.size()) odd->add("passed by", counted(bytes.size() - at, "byte", "bytes") + " behind the last chunk");
  // a plain file goes to tinygltf as it is, without a copy
  chunks.is_plain =
      length == bytes.size() && others == 0 && at == bytes.size() && chunks.text.size() % 4 == 0 && !chunks.bin.empty();
  return chunks;
}

// A .glb of these two chunks.
Bytes binaryOf(const std::string& path, std::string text, std::string_view bin) {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const uint64_t bin_length = (bin.size() + 3) / 4 * 4, length = 28 + text.size() + bin_length;
  if (length > kMaxSceneBytes) throw InputError(path, "file", "less than 4 GiB", std::to_string(length));
  Bytes whole(length, 0);
  auto at = whole.begin();
  const auto add = [&](std::string_view part) { at = std::copy(part.begin(), part.end(), at); };
  const auto addWord = [&](uint64_t word) {
    for (int i = 0; i < 4; ++i) *at++ = static_cast<unsigned char>(word >> (8 * i));
  };
  add({"glTF\2\0\0\0", 8});
  addWord(length);
  addWord(text.size());
  add("JSON");
  add(text);
  addWord(bin_length);
  add({"BIN\0", 4});
  add(bin);
  return whole;
}

// The files of buffers, in the order in which tinygltf asks for them, by whatever name: it decodes addresses otherwise. It may open no
// other.
struct BufferFiles {
  std::vector<std::string> paths;
  SceneBudget* bytes_left;
  size_t next = 0;
};

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

// Bytes of images lie where they will be found.
bool keepPacked(tinygltf::Image*, const int, std::string*, std::string*, int, int, const unsigned char*, int, void*) {
  return true;
}

// tinygltf's words as part of one line.
std::string oneLine(std::string words) {
  std::replace(words.begin(), words.end(), '\n', ' ');
  return words.empty() ? "something else" : words.substr(0, 200);
}

}  // namespace

tinygltf::Model loadGltfFile(const std::string& path, SceneBudget& bytes_left, Oddities* odd) {
  Bytes bytes = readSceneFile(path, "file", bytes_left);
  if (bytes.empty()) throw InputError(path, "file", "glTF", "an empty file");
  GlbChunks chunks;
  // both containers end as a JSON text and one chunk of bytes
  if (isBinary(bytes))
    chunks = chunksOf(path, bytes, odd);
  else
    chunks.text = {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  const bool is_binary = !chunks.bin.empty();
  // what tinygltf would refuse or trip over is repaired in a plain text that stands in the file's place
  GltfJson json = readGltfJson(path, chunks.text, is_binary, odd);
  BufferFiles files{json.buffer_files, &bytes_left};
  // what all of them hold is known before the first is read
  SceneBudget all = bytes_left;
  for (const std::string& file : files.paths) all.take(InputFile(file, "buffer").size(), path, "buffer " + file);
  if (json.plain_text.empty() && (is_binary ? !chunks.is_plain : chunks.text.size() < bytes.size()))
    json.plain_text = chunks.text;
  if (is_binary && !json.plain_text.empty()) bytes = binaryOf(path, std::move(json.plain_text), chunks.bin);
  if (!is_binary && !json.plain_text.empty()) bytes.assign(json.plain_text.begin(), json.plain_text.end());

  // images stay packed and buffers come from files already checked: tinygltf opens nothing itself
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
  // compressed buffers are unpacked before anything reads an accessor
  unpackMeshopt(path, model, bytes_left, odd);
  unpackDraco(path, model, bytes_left, odd);
  return model;
}

}  // namespace nlg
