#include "viewer/data_script.h"

#include <bit>

#include "tool/base64.h"

namespace nlg {

static_assert(std::endian::native == std::endian::little, "arrays of a page are little-endian");

std::string DataScript::text() const {
  nlohmann::ordered_json all = facts;
  all["arrays"] = arrays_;
  // no name of a scene may break its encoding
  const std::string json = all.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  return "nlgReceive(\"" + name_ + "\", " + json + ", \"" + base64(bytes_) + "\");\n";
}

}  // namespace nlg
