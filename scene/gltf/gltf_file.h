// Loads the model of a glTF file; every file that it refers to is opened by our reader.
#pragma once

#include <string>

#include <tiny_gltf.h>

#include "scene/archive/scene_file.h"
#include "scene/model/oddities.h"

namespace nlg {

// Reads the file and its external buffers; files of images are not opened, and none is decoded: those of data URIs
// stand in Image::image as they are packed. What was packed is plain (gltf_packed.h).
// Checked: the container, the JSON's grammar, types and URIs, each buffer's length. Not checked: what the numbers
// refer to.
//
// bytes_left   of kMaxSceneBytes, for all that is read and unpacked
// odd          receives what was mended or left out (gltf_json.h), and what does not unpack
// throws       InputError as readGltf does
tinygltf::Model loadGltfFile(const std::string& path, SceneBudget& bytes_left, Oddities* odd);

}  // namespace nlg
