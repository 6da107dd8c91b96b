// Finds the nodes of a glTF file that are not seen: hidden ones, coarser levels of detail, colliders, triggers, and those that
// the user leaves out.
#pragma once

#include <string>
#include <vector>

#include <tiny_gltf.h>

namespace nlg {

struct NodeVerdict {
  std::string why;             // it is left out; empty: it stays
  bool with_children = false;  // all that hangs on it goes, too; otherwise its own mesh alone
};

inline constexpr const char* kCoarserNodes = "coarser levels of detail (MSFT_lod)";

// Of all nodes that these roots reach. In this order: patterns of names, with * and ?; KHR_node_visibility; the extra nlg_ignore, true or,
// against all that follows, false; MSFT_lod, and triggers of physics; names of skies; engines' own rules for names,
// of which those for levels of detail ask for a finer level of the same name.
//
// notes   receives the patterns that no name has
std::vector<NodeVerdict> judgeNodes(const tinygltf::Model& model, std::vector<int> nodes,
                                    const std::vector<std::string>& patterns, std::vector<std::string>* notes);

// Whether the node's extras have the key as true, or as a number other than 0.
bool isMarked(const tinygltf::Node& node, const char* key);

// The node's name, else its mesh's, else "node 3".
std::string nodeName(const tinygltf::Model& model, int node_idx);
// The nodes that MSFT_lod gives it as coarser and coarser ones.
std::vector<int> coarserNodes(const tinygltf::Model& model, const tinygltf::Node& node);
// A member of an extension; null where there is none.
const tinygltf::Value* memberOf(const tinygltf::ExtensionMap& extensions, const std::string& name, const char* key);

// What nodes hold: lamps and suns, and meshes by name.
struct NodeHoldings {
  size_t lamp_count = 0;
  std::vector<std::string> objects;

  void add(const tinygltf::Model& model, int node_idx);
  std::string text() const;  // "3 lamps, 2 objects (door, wall)"; empty of nothing
};

}  // namespace nlg
