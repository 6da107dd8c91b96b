// Quantities as people read them.
#pragma once

#include <cstdint>
#include <string>

namespace nlg {

// "12,345".
std::string countText(uint64_t count);

// "1 probe", "12,345 probes".
// noun   one of them; its plural adds an s
std::string countText(uint64_t count, const std::string& noun);

// The same of an estimate: two digits of it.
std::string roughCountText(double count, const std::string& noun);

// "45 kB", "3.1 MB", "2.4 GB".
std::string bytesText(double bytes);

// "2.3 s" below ten seconds, then "22 s", "3 min 05 s", "2 h 07 min".
std::string durationText(double seconds);

}  // namespace nlg
