// The JSON of a glTF file, held against the format before tinygltf makes a model of it.
//
// tinygltf opens whatever a URI names, takes a setting of a wrong type for an absent one, cuts integers to 32 bits, copies the
// binary chunk once for every buffer without a URI and recurses as deep as the text does. All of that is refused here, by
// place, so that what tinygltf sees is what the text says.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace nlg {

struct GltfJson {
  std::vector<std::string> buffer_files;  // the external buffers' addresses, as they are written
  // What tinygltf takes instead of the file's own text, if not empty. It refuses what extensions pack: here fallback buffers without
  // a URI hold one byte, and primitives packed by Draco have no indices, whose accessors need no buffer view.
  std::string plain_text;
};

// A buffer needs a URI, but for the first one of a .glb and for fallbacks of EXT_meshopt_compression.
//
// path      the file's name, for errors; text: its JSON; is_binary: from a .glb
// throws    InputError naming the place ("nodes[3].translation[1]", "byte 17 of the JSON")
GltfJson readGltfJson(const std::string& path, std::string_view text, bool is_binary);

}  // namespace nlg
