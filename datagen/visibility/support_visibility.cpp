#include "datagen/visibility/support_visibility.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace nlg {
namespace {

// 14 directions: the axes and diagonals of a cube, turned so that none runs along the walls of axis-aligned levels.
const std::array<glm::vec3, 14>& voteDirections() {
  static const std::array<glm::vec3, 14> directions = [] {
    std::array<glm::vec3, 14> result;
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

}  // namespace

SupportVisibility::SupportVisibility(const RayScene& scene, const LinkTable& links)
    : scene_(scene), table_(links), seen_(links.points.size()), state_(links.points.size()), link_state_(links.links.size()) {}

void SupportVisibility::beginProbe(const glm::vec3& position_m, float spacing_m) {
  position_ = position_m;
  spacing_ = spacing_m;
  std::fill(seen_.begin(), seen_.end(), uint8_t{0});
  std::fill(state_.begin(), state_.end(), State::unknown);
  std::fill(link_state_.begin(), link_state_.end(), LinkState::untested);
}

glm::vec3 SupportVisibility::worldPoint(uint32_t point) const {
  const LocalPoint& local = table_.points[point];
  return position_ + spacing_ * glm::vec3(local[0], local[1], local[2]);
}

bool SupportVisibility::supportIsEmpty() const { return !scene_.anyTriangleInCube(position_, spacing_); }

SolidVote SupportVisibility::vote(const glm::vec3& origin) const {
  SolidVote vote;
  for (const glm::vec3& direction : voteDirections()) {
    const Facing facing = scene_.firstFacing(origin, direction);
    vote.front += facing == Facing::front;
    vote.back += facing == Facing::back;
  }
  ray_count_ += voteDirections().size();
  return vote;
}

SolidVote SupportVisibility::probeVote() const { return vote(position_); }

void SupportVisibility::traceProbeRays() {
  SegmentPacket packet;
  const int point_count = table_.pointCount();
  for (int begin = 0; begin < point_count; begin += kPacketSize) {
    const int count = std::min(kPacketSize, point_count - begin);
    for (int i = 0; i < kPacketSize; ++i) {
      const LocalPoint& local = table_.points[begin + std::min(i, count - 1)];
      packet.origin_x[i] = position_.x;
      packet.origin_y[i] = position_.y;
      packet.origin_z[i] = position_.z;
      packet.direction_x[i] = spacing_ * local[0];
      packet.direction_y[i] = spacing_ * local[1];
      packet.direction_z[i] = spacing_ * local[2];
    }
    const uint32_t hits = scene_.occluded(packet, count);
    for (int i = 0; i < count; ++i) seen_[begin + i] = !(hits >> i & 1);
  }
  ray_count_ += point_count;
}

void SupportVisibility::testLinks(const std::vector<uint32_t>& links) {
  batch_.clear();
  for (const uint32_t link : links) {
    if (link_state_[link] != LinkState::untested) continue;
    link_state_[link] = LinkState::open;  // until its ray says otherwise; also keeps a link from being traced twice
    batch_.push_back(link);
  }
  SegmentPacket packet;
  for (size_t begin = 0; begin < batch_.size(); begin += kPacketSize) {
    const int count = static_cast<int>(std::min<size_t>(kPacketSize, batch_.size() - begin));
    for (int i = 0; i < kPacketSize; ++i) {
      const LinkTable::Link& link = table_.links[batch_[begin + std::min(i, count - 1)]];
      const glm::vec3 a = worldPoint(link.a), b = worldPoint(link.b);
      packet.origin_x[i] = a.x;
      packet.origin_y[i] = a.y;
      packet.origin_z[i] = a.z;
      packet.direction_x[i] = b.x - a.x;
      packet.direction_y[i] = b.y - a.y;
      packet.direction_z[i] = b.z - a.z;
    }
    const uint32_t hits = scene_.occluded(packet, count);
    for (int i = 0; i < count; ++i) {
      if (hits >> i & 1) link_state_[batch_[begin + i]] = LinkState::blocked;
    }
  }
  ray_count_ += batch_.size();
}

// Gives `carried` to the targets of all steps whose link is open, and appends them to `reached`. Most targets are reached by the
// first of their links, so each tests one; only those that it did not reach test the others too.
void SupportVisibility::takeSteps(State carried, std::vector<uint32_t>* reached) {
  first_links_.clear();
  for (const Step& step : steps_) {
    if (state_[step.target] != State::unknown) continue;
    state_[step.target] = State::asked;
    first_links_.push_back(step.link);
  }
  testLinks(first_links_);
  const auto takeOpenSteps = [&] {
    for (const Step& step : steps_) {
      if (state_[step.target] != State::asked || link_state_[step.link] != LinkState::open) continue;
      state_[step.target] = carried;
      reached->push_back(step.target);
    }
  };
  takeOpenSteps();
  first_links_.clear();
  for (const Step& step : steps_) {
    if (state_[step.target] == State::asked) first_links_.push_back(step.link);
  }
  testLinks(first_links_);
  takeOpenSteps();
  for (const Step& step : steps_) {
    if (state_[step.target] == State::asked) state_[step.target] = State::unknown;
  }
}

// Carries a state from the points of `members` on over open links until nothing more is reached; members grows by what is.
void SupportVisibility::flood(State carried, std::vector<uint32_t>* members) {
  for (size_t begin = 0, end = members->size(); begin < end; begin = end, end = members->size()) {
    steps_.clear();
    for (size_t i = begin; i < end; ++i) {
      const uint32_t point = (*members)[i];
      if (point >= kSupportPointCount) continue;  // nothing reads an unseen point
      for (uint32_t e = table_.first_edge[point]; e < table_.first_edge[point + 1]; ++e) {
        const LinkTable::Edge& edge = table_.edges[e];
        if (state_[edge.point] == State::unknown && link_state_[edge.link] != LinkState::blocked)
          steps_.push_back({edge.point, edge.link});
      }
    }
    takeSteps(carried, members);
  }
}

bool SupportVisibility::findValidity() {
  std::vector<uint32_t>& members = members_;
  const auto point_count = static_cast<uint32_t>(table_.points.size());
  for (uint32_t point = 0; point < point_count; ++point) state_[point] = seen_[point] ? State::valid : State::unknown;
  // the first wave is found from the side of the points that the probe does not see: they are fewer than those it does
  members.clear();
  steps_.clear();
  for (uint32_t point = 0; point < point_count; ++point) {
    if (seen_[point]) continue;
    for (uint32_t e = table_.first_edge[point]; e < table_.first_edge[point + 1]; ++e) {
      const LinkTable::Edge& edge = table_.edges[e];
      if (edge.point < kSupportPointCount && seen_[edge.point]) steps_.push_back({point, edge.link});
    }
  }
  takeSteps(State::valid, &members);
  flood(State::valid, &members);
  bool disputed = false;
  for (uint32_t point = 0; point < point_count; ++point) {
    if (state_[point] != State::unknown) continue;
    // a group of its own: gather it first, then let a few of its members vote
    state_[point] = State::solid;
    members.assign(1, point);
    flood(State::solid, &members);
    SolidVote total;
    const size_t stride = std::max<size_t>(1, members.size() / 3);
    for (size_t i = 0; i < members.size(); i += stride) {
      const SolidVote one = vote(worldPoint(members[i]));
      total.front += one.front;
      total.back += one.back;
    }
    disputed |= total.disputed();
    if (total.solid()) continue;
    for (const uint32_t member : members) state_[member] = State::valid;
  }
  return disputed;
}

}  // namespace nlg
