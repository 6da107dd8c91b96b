#include "datagen/visibility/support_visibility.h"

#include <algorithm>

#include "datagen/visibility/cavity.h"

namespace nlg {

// 14 directions: the axes and diagonals of a cube, turned so that none runs along the walls of axis-aligned levels.
const std::array<glm::vec3, kSolidVoteRays>& voteDirections() {
  static const std::array<glm::vec3, kSolidVoteRays> directions = [] {
    std::array<glm::vec3, kSolidVoteRays> result;
    int count = 0;
    const glm::vec3 x(0.8018f, 0.5345f, 0.2673f), y(-0.5774f, 0.5774f, 0.5774f);
    const glm::vec3 z = glm::cross(x, y);
    for (const float sign : {-1.0f, 1.0f}) {
      for (const glm::vec3& axis : {x, y, z}) result[count++] = sign * axis;
    }
    for (int corner = 0; corner < 8; ++corner) {
      const auto sign = [&](int bit) { return corner >> bit & 1 ? 1.0f : -1.0f; };
      result[count++] = glm::normalize(sign(0) * x + sign(1) * y + sign(2) * z);
    }
    return result;
  }();
  return directions;
}

namespace {

template <class FirstFacing>
SolidVote voteOf(const FirstFacing& first_facing) {
  SolidVote vote;
  for (const glm::vec3& direction : voteDirections()) {
    const Facing facing = first_facing(direction);
    vote.front += facing == Facing::front;
    vote.back += facing == Facing::back;
    vote.nothing += facing == Facing::nothing;
  }
  return vote;
}

}  // namespace

SolidVote solidVote(const RayScene& rays, const glm::dvec3& position_m) {
  return voteOf([&](const glm::vec3& direction) { return rays.firstFacing(glm::vec3(position_m), direction); });
}

SolidVote solidVoteWithSky(const RayScene& rays, const glm::dvec3& position_m) {
  return voteOf([&](const glm::vec3& direction) { return rays.firstFacingWithSky(glm::vec3(position_m), direction); });
}

SupportVisibility::SupportVisibility(const RayScene& scene, const LinkTable& links)
    : scene_(scene),
      table_(links),
      seen_(links.points.size()),
      state_(links.points.size()),
      blocked_points_(links.point_packets.tree.packetCount()),
      blocked_links_(links.link_packets.tree.packetCount()) {}

void SupportVisibility::beginProbe(const glm::dvec3& position_m, float spacing_m) {
  position_ = position_m;
  spacing_ = spacing_m;
  asked_.clear();
  triangles_.clear();
  scene_.trianglesNearCube(glm::vec3(position_m), spacing_m, &candidates_);
  collectLocalTriangles(scene_.positions(), scene_.triangles(), candidates_, position_m, spacing_, &triangles_);
}

SolidVote SupportVisibility::voteAt(const glm::dvec3& position_m) const {
  SolidVote vote = raysAt(position_m);
  vote.in_cavity = !vote.solid() && isInCavity(scene_, position_m);
  return vote;
}

SolidVote SupportVisibility::raysAt(const glm::dvec3& position_m) const {
  ray_count_ += kSolidVoteRays;
  const SolidVote vote = solidVote(scene_, position_m);
  if (!vote.solid() || !scene_.hasSkyFaces()) return vote;
  // high in a level rays pass over its rim and meet walls from outside: the sky stands between, and they are no evidence
  ray_count_ += kSolidVoteRays;
  const SolidVote under_sky = solidVoteWithSky(scene_, position_m);
  return under_sky.solid() ? vote : under_sky;
}

void SupportVisibility::traceRays(const LocalPoint& eye) {
  eye_ = eye;
  const PacketTree& tree = table_.point_packets.tree;
  blockRays(table_.point_packets, triangles_, eye, blocked_points_.data());
  for (size_t place = 0; place < tree.order.size(); ++place) {
    seen_[tree.order[place]] = !(blocked_points_[place / kPacketLanes] >> (place % kPacketLanes) & 1);
  }
  dark_.clear();
  for (uint32_t point = 0; point < seen_.size(); ++point) {
    if (!seen_[point]) dark_.push_back(point);
  }
}

bool SupportVisibility::isOpen(const LocalPoint& from, const LocalPoint& to) const {
  return std::none_of(triangles_.begin(), triangles_.end(),
                      [&](const LocalTriangle& triangle) { return segmentMeets(triangle, from, to); });
}

void SupportVisibility::testLinks() {
  packet_test_count_ += blockLinks(table_.link_packets, triangles_, &scratch_, blocked_links_.data());
}

bool SupportVisibility::reachesValid(uint32_t point) const {
  const State* state = state_.data();
  const uint16_t* other = table_.edge_point.data();
  for (uint32_t e = table_.first_edge[point], end = table_.first_test_edge[point]; e < end; ++e) {
    if (state[other[e]] == State::valid && linkOpen(table_.edge_link[e])) return true;
  }
  return false;
}

// Carries a state from the points of `members` on over open links until nothing more is reached; members grows by what is.
void SupportVisibility::flood(State carried, std::vector<uint32_t>* members) {
  State* state = state_.data();
  const uint16_t* other = table_.edge_point.data();
  for (size_t i = 0; i < members->size(); ++i) {
    const uint32_t point = (*members)[i];
    if (point >= kSupportPointCount) continue;  // nothing reads a test point
    for (uint32_t e = table_.first_edge[point], end = table_.first_edge[point + 1]; e < end; ++e) {
      const uint32_t reached = other[e];
      if (state[reached] != State::unknown || !linkOpen(table_.edge_link[e])) continue;
      state[reached] = carried;
      members->push_back(reached);
    }
  }
}

glm::dvec3 SupportVisibility::pointPosition(uint32_t point) const {
  const LocalPoint& local = table_.points[point];
  return position_ + spacing_ * glm::dvec3(local[0], local[1], local[2]);
}

SolidVote SupportVisibility::groupVote(const std::vector<uint32_t>& members) const {
  FarQuestion question;
  const size_t stride = std::max<size_t>(1, members.size() / 3);
  for (size_t i = 0; i < members.size(); i += stride) question.points[question.point_count++] = static_cast<uint16_t>(members[i]);
  SolidVote total;
  asked_.push_back(answered(question, &total));
  return total;
}

bool SupportVisibility::isBehindSky(uint32_t point) const {
  FarQuestion question;
  question.kind = FarQuestion::Kind::sky;
  question.point_count = 1;
  question.points[0] = static_cast<uint16_t>(point);
  SolidVote vote;
  asked_.push_back(answered(question, &vote));
  return vote.solid();
}

FarQuestion SupportVisibility::answered(FarQuestion question, SolidVote* vote) const {
  if (question.kind == FarQuestion::Kind::group) {
    for (size_t i = 0; i < question.point_count && !vote->unanimous(); ++i) {
      const SolidVote one = raysAt(pointPosition(question.points[i]));
      vote->front += one.front;
      vote->back += one.back;
    }
    vote->in_cavity = !vote->solid() && isInCavity(scene_, pointPosition(question.points.front()));
  } else if (scene_.hasSkyFaces()) {
    ray_count_ += kSolidVoteRays;
    *vote = solidVoteWithSky(scene_, pointPosition(question.points.front()));
  }
  question.solid = vote->solid();
  question.disputed = vote->disputed();
  return question;
}

bool SupportVisibility::answersAlike(const FarQuestion& question) const {
  SolidVote vote;
  return answered(question, &vote) == question;
}

bool SupportVisibility::findValidity() {
  std::fill(state_.begin(), state_.end(), State::valid);
  for (const uint32_t point : dark_) state_[point] = State::unknown;
  // the first step is found from the side of the dark points: they are fewer than those that the probe sees
  members_.clear();
  for (const uint32_t point : dark_) {
    if (!reachesValid(point)) continue;
    state_[point] = State::valid;
    members_.push_back(point);
  }
  flood(State::valid, &members_);
  bool disputed = false;
  for (const uint32_t point : dark_) {
    if (state_[point] != State::unknown) continue;
    // a group of its own: gather it first, then let a few of its members vote
    state_[point] = State::solid;
    members_.assign(1, point);
    flood(State::solid, &members_);
    const SolidVote total = groupVote(members_);
    disputed |= total.disputed();
    if (total.solid()) continue;
    for (const uint32_t member : members_) state_[member] = State::valid;
  }
  return disputed;
}

}  // namespace nlg
