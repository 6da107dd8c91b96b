// What --help and --help-all print: the options that a user needs first, and all of them by groups.
#pragma once

#include <string>

#include "tool/options.h"

namespace nlg {

enum class HelpExtent { common, all };

// Adds --help and --help-all to app. Without this it has CLI11's own --help.
void addHelpFlags(CLI::App& app);

// The text. Lines are broken at 100 columns. app and its options are changed on the way: it is of no use afterwards.
// table   says which options are common (OptionTable::common)
std::string helpText(CLI::App& app, const OptionTable& table, HelpExtent extent);

}  // namespace nlg
