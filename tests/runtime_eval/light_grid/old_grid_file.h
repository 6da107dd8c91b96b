// Files of light grids as earlier versions wrote them, for tests of what reads them.
#pragma once

#include <string>
#include <vector>

#include "runtime_eval/light_grid/light_grid_file.h"
#include "runtime_eval/light_grid/probe_tree_data.h"
#include "runtime_eval/weights_file/tensor_file.h"

namespace nlg {

// A file of version 1, as it was written before light: the tree with all lists that follow from its nodes.
// grid   one that checkLightGrid accepts
inline std::string oldGridBytes(const LightGrid& grid, const GridMetadata& metadata) {
  const ProbeTreeData tree = probeTreeData(grid.tree);
  const ProbeTreeLists lists = probeTreeLists(grid.tree);
  const std::vector<double> first_m(tree.frame.first_m.begin(), tree.frame.first_m.end()), spacing_m{tree.frame.spacing_m};
  const std::vector<int32_t> root_count(tree.frame.root_count.begin(), tree.frame.root_count.end());
  TensorFileWriter writer;
  writer.add("frame.first_m", first_m);
  writer.add("frame.spacing_m", spacing_m);
  writer.add("frame.root_count", root_count);
  writer.add("node.child_mask", tree.child_mask);
  writer.add("node.used_mask", tree.used_mask);
  writer.add("node.first_child", lists.first_child);
  writer.add("node.first_slot", lists.first_slot);
  writer.add("node.cell_log2", lists.cell_log2);
  writer.add("node.cell_count", tree.cell_count);
  writer.add("slots", lists.slots);
  writer.add("probe.key", lists.probe_keys);
  writer.add("probe.log2", lists.probe_log2);
  writer.add("probe.function", grid.probe_function);
  writer.add("function.representation", grid.function_representation);
  writer.add("theta", grid.theta);
  std::string bytes;
  // the texts of the grid's own are those of today's version but for two
  serializeLightGrid(grid, {ThetaPrecision::float32}, metadata, &bytes);
  TensorFileReader today;
  today.openBytes(bytes);
  GridMetadata texts = today.metadata();
  texts["version"] = "1";
  texts.erase("light");
  writer.serialize(texts, &bytes);
  return bytes;
}

}  // namespace nlg
