#include "scene/procedural/columns.h"

namespace nlg {

void addColumn(Level& level, const Columns& columns, double x, double z, double height) {
  level.mesh.beginObject("column", Mobility::movable);
  const double r = columns.radius;
  const std::vector<Ring> rings = {
      {0, 1.5 * r}, {0.2, 1.5 * r}, {0.3, r}, {height - 0.35, 0.85 * r}, {height - 0.15, 1.35 * r}, {height, 1.35 * r}};
  addLathe(level.mesh, {{x, 0, z}, turnByDegrees(columns.side_count == 4 ? 45.0 : 0.0)}, rings, columns.side_count,
           level.palette.stone);
}

void addArcade(Level& level, const Columns& columns, const Placement& start, int bay_count, double top_m) {
  level.mesh.beginObject("arcade", Mobility::structure);
  const double half = 0.75 * columns.radius;
  std::vector<ProfilePoint> profile;
  if (!columns.has_arches)
    profile = {{-half, columns.column_m, top_m}, {bay_count * columns.bay + half, columns.column_m, top_m}};
  constexpr int kSegments = 10;
  const double span = 0.5 * columns.bay - half;
  if (columns.has_arches) profile.push_back({-half, columns.column_m, top_m});
  for (int bay = 0; bay < bay_count && columns.has_arches; ++bay) {
    for (int i = 0; i <= kSegments; ++i) {
      const Turn angle = turnByDegrees(180.0 * i / kSegments);
      profile.push_back({(bay + 0.5) * columns.bay - span * angle.cosine, columns.column_m + span * angle.sine, top_m});
    }
  }
  if (columns.has_arches) profile.push_back({bay_count * columns.bay + half, columns.column_m, top_m});
  addProfile(level.mesh, start, profile, -half, half, level.palette.wall);
}

void addColumnRow(Level& level, const Columns& columns, const Placement& start, int bay_count, double top_m, bool has_ends) {
  for (int i = has_ends ? 0 : 1; i <= bay_count - (has_ends ? 0 : 1); ++i) {
    const glm::dvec3 foot = start.apply({i * columns.bay, 0, 0});
    addColumn(level, columns, foot.x, foot.z, columns.column_m);
  }
  addArcade(level, columns, start, bay_count, top_m);
}

}  // namespace nlg
