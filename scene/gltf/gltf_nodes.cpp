#include "scene/gltf/gltf_nodes.h"

#include <fnmatch.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "scene/archive/pk3_archive.h"
#include "scene/model/oddities.h"

namespace nlg {
namespace {

// Names by which engines' importers know what is not drawn, in lower case. Unreal has beginnings ("FBX static mesh pipeline"); Godot has
// ends, behind any of -, _ and $, and with numbers behind them ("Node type customization using name suffixes").
struct NameRule {
  std::string_view word;
  bool is_prefix, with_children;
};
constexpr NameRule kNameRules[] = {{"noimp", false, true},    {"navmesh", false, false},     {"occonly", false, false},
                                   {"colonly", false, false}, {"convcolonly", false, false}, {"ucx_", true, false},
                                   {"ubx_", true, false},     {"usp_", true, false},         {"ucp_", true, false},
                                   {"mcdcx_", true, false}};

std::string without(const char* last_ones, const std::string& name) {
  return name.substr(0, name.find_last_not_of(last_ones) + 1);
}

// "arch" and 1 of Arch_LOD1, and of its copy Arch_LOD1.001; without a level the name alone.
std::pair<std::string, std::optional<int>> levelOf(const std::string& name) {
  std::string whole = lowerCase(name);
  const size_t dot = whole.find_last_of('.');
  if (dot != std::string::npos && without("0123456789", whole).size() == dot + 1) whole.resize(dot);
  const std::string plain = without("0123456789", whole);
  if (plain.size() == whole.size() || !(plain.ends_with("_lod") || plain.ends_with("-lod"))) return {whole, std::nullopt};
  return {plain.substr(0, plain.size() - 4), std::stoi(whole.substr(plain.size(), 4))};
}

bool is(const tinygltf::Value* value, bool truth) { return value != nullptr && value->IsBool() && value->Get<bool>() == truth; }

}  // namespace

bool isMarked(const tinygltf::Node& node, const char* key) {
  if (!node.extras.IsObject() || !node.extras.Has(key)) return false;
  const tinygltf::Value& extra = node.extras.Get(key);
  // Blender before 3.5 and other programs without booleans write 1
  return is(&extra, true) || (extra.IsNumber() && extra.GetNumberAsDouble() != 0.0);
}

namespace {

// A dome with a picture of the sky, as it is called: to light it would be a wall around the level.
constexpr std::string_view kSkyNames[] = {"sky", "skydome", "skybox", "skysphere"};

NodeVerdict ofName(const std::string& name) {
  const std::string whole = lowerCase(name), start = without("0123456789._ ", whole);
  std::string letters = start;
  std::erase_if(letters, [](char c) { return c == '_' || c == '-' || c == ' '; });
  if (std::find(std::begin(kSkyNames), std::end(kSkyNames), letters) != std::end(kSkyNames))
    return {"for a sky and no wall, by its name; --sky says what shines", false};
  for (const auto& [word, is_prefix, with_children] : kNameRules) {
    const size_t at = start.size() - word.size();
    const bool is_end =
        start.size() > word.size() && start.ends_with(word) && std::string_view("-_$").find(start[at - 1]) != std::string::npos;
    if (is_prefix ? whole.starts_with(word) : is_end)
      return {fmt::format("by an engine's rule for names ({}{})", is_prefix ? "" : "-", word), with_children};
  }
  return {};
}

// By what the file marks; is_settled: no rule for names may say otherwise.
NodeVerdict ofMarks(const tinygltf::Node& node, bool is_coarser, bool* is_settled) {
  *is_settled = true;
  if (is(memberOf(node.extensions, "KHR_node_visibility", "visible"), false)) return {"hidden by KHR_node_visibility", true};
  if (node.extras.IsObject() && node.extras.Has("nlg_ignore")) {
    return isMarked(node, "nlg_ignore") ? NodeVerdict{"by nlg_ignore", true} : NodeVerdict{};
  }
  if (is_coarser) return {kCoarserNodes, true};
  for (const char* physics : {"OMI_physics_body", "KHR_physics_rigid_bodies"}) {
    if (memberOf(node.extensions, physics, "trigger") != nullptr) return {"triggers of physics", false};
  }
  *is_settled = false;
  return {};
}

}  // namespace

std::vector<NodeVerdict> judgeNodes(const tinygltf::Model& model, std::vector<int> nodes,
                                    const std::vector<std::string>& patterns, std::vector<std::string>* notes) {
  std::set<int> coarser;
  for (const tinygltf::Node& node : model.nodes) {
    for (const int idx : coarserNodes(model, node)) coarser.insert(idx);
  }
  std::vector<NodeVerdict> verdicts(model.nodes.size());
  std::vector<char> is_seen(verdicts.size(), 0);
  std::vector<int> by_name;
  std::map<std::string, int> finest;  // level, by name without it
  std::set<std::string> idle(patterns.begin(), patterns.end());
  while (!nodes.empty()) {
    const int idx = nodes.back();
    nodes.pop_back();
    if (idx < 0 || static_cast<size_t>(idx) >= verdicts.size() || std::exchange(is_seen[static_cast<size_t>(idx)], 1)) continue;
    const tinygltf::Node& node = model.nodes[static_cast<size_t>(idx)];
    NodeVerdict& verdict = verdicts[static_cast<size_t>(idx)];
    const std::string name = nodeName(model, idx);
    bool is_settled = false;
    verdict = ofMarks(node, coarser.count(idx) > 0, &is_settled);
    for (const std::string& pattern : patterns) {
      if (fnmatch(pattern.c_str(), name.c_str(), 0) != 0) continue;
      verdict = {"by --leave-out " + pattern, true};
      idle.erase(pattern);
    }
    if (verdict.with_children) continue;
    nodes.insert(nodes.end(), node.children.begin(), node.children.end());
    if (!is_settled) by_name.push_back(idx);
    const auto [start, level] = levelOf(name);
    // a group that is named like its levels is none of them
    if (level || node.mesh >= 0)
      finest[start] = std::min(finest.try_emplace(start, level.value_or(0)).first->second, level.value_or(0));
  }
  for (const int idx : by_name) {
    const auto [start, level] = levelOf(nodeName(model, idx));
    const bool is_coarser = level && *level > finest[start];
    verdicts[static_cast<size_t>(idx)] =
        is_coarser ? NodeVerdict{"coarser levels of detail by name (_LOD1)", true} : ofName(nodeName(model, idx));
  }
  for (const std::string& pattern : idle) notes->push_back("--leave-out " + pattern + ": no node that is read has such a name");
  return verdicts;
}

std::string nodeName(const tinygltf::Model& model, int node_idx) {
  const tinygltf::Node& node = model.nodes[static_cast<size_t>(node_idx)];
  if (!node.name.empty()) return node.name;
  const bool has_mesh = node.mesh >= 0 && static_cast<size_t>(node.mesh) < model.meshes.size();
  const std::string mesh = has_mesh ? model.meshes[static_cast<size_t>(node.mesh)].name : "";
  return mesh.empty() ? "node " + std::to_string(node_idx) : mesh;
}

const tinygltf::Value* memberOf(const tinygltf::ExtensionMap& extensions, const std::string& name, const char* key) {
  const auto found = extensions.find(name);
  return found == extensions.end() || !found->second.Has(key) ? nullptr : &found->second.Get(key);
}

std::vector<int> coarserNodes(const tinygltf::Model& model, const tinygltf::Node& node) {
  std::vector<int> nodes;
  const tinygltf::Value* ids = memberOf(node.extensions, "MSFT_lod", "ids");
  for (size_t i = 0; ids != nullptr && i < ids->ArrayLen(); ++i) {
    const tinygltf::Value& id = ids->Get(static_cast<int>(i));
    const double idx = id.IsNumber() ? id.GetNumberAsDouble() : -1.0;
    if (idx >= 0.0 && idx < static_cast<double>(model.nodes.size())) nodes.push_back(static_cast<int>(idx));
  }
  return nodes;
}

void NodeHoldings::add(const tinygltf::Model& model, int node_idx) {
  const tinygltf::Node& node = model.nodes[static_cast<size_t>(node_idx)];
  lamp_count += memberOf(node.extensions, "KHR_lights_punctual", "light") != nullptr ? 1 : 0;
  if (node.mesh >= 0) objects.push_back(nodeName(model, node_idx));
}

std::string NodeHoldings::text() const {
  const std::string lamps = lamp_count == 0 ? "" : counted(lamp_count, "lamp", "lamps");
  if (objects.empty()) return lamps;
  return (lamps.empty() ? "" : lamps + ", ") + counted(objects.size(), "object", "objects") + " (" + listed(objects) + ")";
}

}  // namespace nlg
