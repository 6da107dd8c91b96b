#include "validate/light/rooms.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "tool/parallel_for.h"

namespace nlg {
namespace {

// What each of some places sees of them all: a row of bits a place.
class Sight {
 public:
  Sight(const RayScene& rays, const std::vector<glm::dvec3>& places, size_t count, double reach_m, int threads)
      : count_(count), words_((count + 63) / 64), bits_(count * words_) {
    parallelFor(count, threads, [&](uint64_t from, int) {
      for (size_t to = 0; to < count; ++to) {
        // asked in one direction, so that sight is mutual to the last bit
        const glm::dvec3 &low = places[std::min<size_t>(from, to)], &high = places[std::max<size_t>(from, to)];
        const bool sees = from == to || (glm::distance(low, high) <= reach_m && !rays.isBlocked(glm::vec3(low), glm::vec3(high)));
        if (sees) bits_[from * words_ + to / 64] |= uint64_t{1} << to % 64;
      }
    });
  }

  bool sees(size_t from, size_t to) const { return (bits_[from * words_ + to / 64] >> to % 64 & 1) != 0; }

  // Of what either sees, the share that both see.
  double alike(size_t a, size_t b) const {
    int both = 0, either = 0;
    for (size_t w = 0; w < words_; ++w) {
      const uint64_t of_a = bits_[a * words_ + w], of_b = bits_[b * words_ + w];
      both += std::popcount(of_a & of_b);
      either += std::popcount(of_a | of_b);
    }
    return static_cast<double>(both) / either;
  }

 private:
  size_t count_, words_;
  std::vector<uint64_t> bits_;
};

constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();

class RoomSearch {
 public:
  RoomSearch(const RayScene& rays, const std::vector<glm::dvec3>& places, const RoomOptions& options)
      : rays_(rays),
        places_(places),
        options_(options),
        count_(std::min(places.size(), options.most_places)),
        sight_(rays, places, count_, options.reach_m, options.threads),
        kin_(count_),
        room_(places.size(), kNone) {
    parallelFor(count_, options.threads, [&](uint64_t a, int) {
      for (size_t b = 0; b < count_; ++b) {
        if (sight_.sees(a, b) && sight_.alike(a, b) >= options.least_alike) kin_[a].push_back(static_cast<uint32_t>(b));
      }
    });
  }

  std::vector<SeenRoom> find() {
    chooseMiddles();
    joinMostAlike();
    joinNearestSeen();
    std::vector<SeenRoom> rooms(middles_.size());
    for (uint32_t i = 0; i < places_.size(); ++i) {
      if (room_[i] != kNone) rooms[room_[i]].places.push_back(i);
    }
    parallelFor(rooms.size(), options_.threads, [&](uint64_t r, int) { rooms[r].middle_m = middleOf(rooms[r].places); });
    std::stable_sort(rooms.begin(), rooms.end(),
                     [](const SeenRoom& a, const SeenRoom& b) { return a.places.size() > b.places.size(); });
    return rooms;
  }

 private:
  // The place with the most places like it that no room has yet, again and again.
  void chooseMiddles() {
    const auto most_left = static_cast<size_t>(options_.left_share * static_cast<double>(count_));
    for (size_t left = count_; left > most_left;) {
      size_t best = 0, best_count = 0;
      for (size_t a = 0; a < count_; ++a) {
        const auto count =
            static_cast<size_t>(std::count_if(kin_[a].begin(), kin_[a].end(), [&](uint32_t b) { return room_[b] == kNone; }));
        if (count > best_count) best = a, best_count = count;
      }
      if (best_count <= most_left / 2) return;  // what is left lies scattered
      for (const uint32_t b : kin_[best]) {
        if (room_[b] == kNone) room_[b] = static_cast<uint32_t>(middles_.size());
      }
      middles_.push_back(static_cast<uint32_t>(best));
      left -= best_count;
    }
  }

  // Whoever came first took what is more like a later one.
  void joinMostAlike() {
    parallelFor(count_, options_.threads, [&](uint64_t a, int) {
      double best = 0.0;
      for (uint32_t r = 0; r < middles_.size(); ++r) {
        if (!sight_.sees(a, middles_[r])) continue;
        const double alike = sight_.alike(a, middles_[r]);
        if (alike >= options_.least_alike && alike > best) best = alike, room_[a] = r;
      }
    });
  }

  void joinNearestSeen() {
    const std::vector<uint32_t> of_middles = room_;
    parallelFor(places_.size(), options_.threads, [&](uint64_t a, int) {
      if (of_middles[a] != kNone) return;
      std::vector<std::pair<double, uint32_t>> near;
      for (uint32_t b = 0; b < count_; ++b) {
        const double distance = glm::distance(places_[a], places_[b]);
        if (of_middles[b] != kNone && distance <= options_.reach_m) near.push_back({distance, b});
      }
      std::sort(near.begin(), near.end());
      for (const auto& [distance, b] : near) {
        if (rays_.isBlocked(glm::vec3(places_[a]), glm::vec3(places_[b]))) continue;
        room_[a] = of_middles[b];
        return;
      }
    });
  }

  // Of the compared places: who sees most of the others, near ones before far ones. One in a window sees all of them, but from afar.
  glm::dvec3 middleOf(const std::vector<uint32_t>& of_room) const {
    const auto end = std::lower_bound(of_room.begin(), of_room.end(), count_);
    uint32_t best = of_room.front();
    double best_sum = -1.0;
    for (auto a = of_room.begin(); a != end; ++a) {
      double sum = 0.0;
      for (auto b = of_room.begin(); b != end; ++b) {
        if (sight_.sees(*a, *b)) sum += options_.reach_m - glm::distance(places_[*a], places_[*b]);
      }
      if (sum > best_sum) best = *a, best_sum = sum;
    }
    return places_[best];
  }

  const RayScene& rays_;
  const std::vector<glm::dvec3>& places_;
  const RoomOptions& options_;
  const size_t count_;
  const Sight sight_;
  std::vector<std::vector<uint32_t>> kin_;  // by place: those it sees that are enough like it
  std::vector<uint32_t> room_, middles_;    // by place; by room
};

}  // namespace

std::vector<SeenRoom> findRooms(const RayScene& rays, const std::vector<glm::dvec3>& places_in_air, const RoomOptions& options) {
  return RoomSearch(rays, places_in_air, options).find();
}

std::vector<uint32_t> roomOfPlaces(const std::vector<SeenRoom>& rooms, size_t place_count) {
  std::vector<uint32_t> room(place_count, static_cast<uint32_t>(rooms.size()));
  for (uint32_t r = 0; r < rooms.size(); ++r) {
    for (const uint32_t place : rooms[r].places) room[place] = r;
  }
  return room;
}

}  // namespace nlg
