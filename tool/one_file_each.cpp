#include "tool/one_file_each.h"

#include <utility>

#include "tool/error.h"

namespace nlg {

OneFileEach::OneFileEach(std::string flag, std::string kind) : flag_(std::move(flag)), kind_(std::move(kind)) {}

void OneFileEach::add(const std::string& path, const std::string& what) {
  const auto [earlier, is_new] = path_of_.emplace(what, path);
  if (!is_new) throw UsageError(flag_, "one file a " + kind_, "two of " + what + ": " + earlier->second + " and " + path);
}

}  // namespace nlg
