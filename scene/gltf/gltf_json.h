// Checks the JSON of a glTF file against the format, before tinygltf reads it.
//
// tinygltf opens whatever a URI names, takes a setting of a wrong type for an absent one, cuts integers to 32 bits, copies the
// binary chunk once for every buffer without a URI, recurses as deep as the text does, and refuses a file for one camera without a type.
// All of that is found here, by place, so that what tinygltf sees is what the text says. What is wrong of one part alone is taken out of
// the text: of a material, a texture or a sampler the member; of any other element all that it says, so that whoever names it finds
// nothing there.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene/model/oddities.h"

namespace nlg {

struct GltfJson {
  std::vector<std::string> buffer_files;  // the external buffers' files
  // What tinygltf takes instead of the file's own text, if not empty: mended, and without what it refuses of what extensions pack.
  // Buffers without a URI hold one byte, and primitives packed by Draco have no indices, whose accessors need no buffer view.
  std::string plain_text;
};

// The unpacked views of meshopt's two extensions lie in buffers that need not exist.
inline constexpr const char* kMeshoptExtensions[] = {"KHR_meshopt_compression", "EXT_meshopt_compression"};

// A buffer needs a URI, but for the first one of a .glb with a binary chunk and for fallbacks of meshopt. One that has none is empty, and so
// is one whose bytes are not there. It is as long as what is there.
//
// path      the file's name, for errors; text: its JSON; has_bin: it is of a .glb with a binary chunk
// odd       receives what was taken out
// throws    InputError naming the place ("scenes[3].nodes[1]", "byte 17 of the JSON") on what is wrong of the whole
// Data URIs (RFC 2397), in base64 or percent-encoded; of an image as the file has them, but for "DATA:", by which tinygltf leaves them alone.
bool isDataUri(const std::string& uri);
// returns   whether it holds one byte or more
bool dataOfUri(const std::string& uri, std::string* bytes);

GltfJson readGltfJson(const std::string& path, std::string_view text, bool has_bin, Oddities* odd);

}  // namespace nlg
