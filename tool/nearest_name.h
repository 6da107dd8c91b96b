// Suggests the name that a misspelt one was meant to be.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace nlg {

// The known name that differs from the given one by the fewest letters, the first of several; none where the fewest are more than
// one, and more than a third of that name's.
std::optional<std::string> nearestName(const std::string& name, const std::vector<std::string>& known);

}  // namespace nlg
