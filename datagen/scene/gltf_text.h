// The JSON of a glTF file, checked before tinygltf reads it.
//
// tinygltf opens whatever a URI names, takes a setting of a wrong type for an absent one, cuts integers to 32 bits, copies the
// binary chunk once for every buffer without a URI and recurses as deep as the text does. All of that is refused here, by
// place, so that what tinygltf sees is what the text says.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace nlg {

// Returns the external buffers' file names, percent-decoded: relative, without "..", without a scheme.
//
// path      the file's name, for errors; text: its JSON; is_binary: from a .glb, whose first buffer needs no URI
// throws    InputError naming the place ("nodes[3].translation[1]", "byte 17 of the JSON")
std::vector<std::string> checkGltfText(const std::string& path, std::string_view text, bool is_binary);

}  // namespace nlg
