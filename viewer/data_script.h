// Numbers as scripts, for a page that is opened from a folder: a browser reads no other files there.
//
//     nlgReceive("NAME", {facts}, "bytes of all arrays, one behind another, in base64");
//
// facts.arrays says of each array its kind, as JavaScript names it, its first byte, a multiple of 4, and how many numbers it has.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace nlg {

class DataScript {
 public:
  explicit DataScript(std::string name) : name_(std::move(name)) {}

  nlohmann::ordered_json facts;  // whatever else the page is to know

  void add(const std::string& array, std::span<const float> numbers) { add(array, "Float32Array", numbers); }
  void add(const std::string& array, std::span<const uint32_t> numbers) { add(array, "Uint32Array", numbers); }
  void add(const std::string& array, std::span<const uint8_t> numbers) { add(array, "Uint8Array", numbers); }

  const std::string& name() const { return name_; }
  void rename(std::string name) { name_ = std::move(name); }
  std::string text() const;

 private:
  template <class Number>
  void add(const std::string& array, const char* kind, std::span<const Number> numbers) {
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    arrays_[array] = {kind, bytes_.size(), numbers.size()};
    const size_t first = bytes_.size();
    bytes_.resize(first + numbers.size_bytes());
    if (!numbers.empty()) std::memcpy(&bytes_[first], numbers.data(), numbers.size_bytes());
  }

  std::string name_, bytes_;
  nlohmann::ordered_json arrays_ = nlohmann::ordered_json::object();
};

}  // namespace nlg
