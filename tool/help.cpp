#include "tool/help.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <sstream>

namespace nlg {
namespace {

constexpr size_t kNameColumns = 26;  // of an option, before its text
constexpr size_t kTextColumns = 74;

// Ends of lines in place of blanks; the formatter indents what follows one.
std::string broken(const std::string& text) {
  std::istringstream words(text);
  std::string lines;
  size_t column = 0;
  for (std::string word; words >> word;) {
    // of UTF-8, bytes that begin a character
    const auto width = static_cast<size_t>(std::count_if(word.begin(), word.end(), [](char c) { return (c & 0xc0) != 0x80; }));
    const bool fits = column + 1 + width <= kTextColumns;
    if (column > 0) lines += fits ? ' ' : '\n';
    column = column > 0 && fits ? column + 1 + width : width;
    lines += word;
  }
  return lines;
}

bool isCommon(const CLI::Option& option, const std::vector<std::string>& names) {
  if (option.get_positional() || option.get_required()) return true;
  std::string name = option.get_name(false, true);
  name = name.substr(name.rfind("--") + 2);
  std::replace(name.begin(), name.end(), '-', '_');
  return name == "help" || name == "help_all" || name == "config" || std::find(names.begin(), names.end(), name) != names.end();
}

std::string withoutDoubleBlankLines(std::string text) {
  for (size_t at; (at = text.find("\n\n\n")) != std::string::npos;) text.erase(at, 1);
  return text;
}

}  // namespace

void addHelpFlags(CLI::App& app) {
  app.set_help_flag("--help,-h", "what is needed first");
  app.set_help_all_flag("--help-all", "all options, by groups");
}

std::string helpText(CLI::App& app, const OptionTable& table, HelpExtent extent) {
  app.get_formatter()->column_width(kNameColumns);
  const std::vector<CLI::Option*> options = app.get_options([](const CLI::Option*) { return true; });
  for (CLI::Option* option : options) option->description(broken(option->get_description()));
  if (extent == HelpExtent::all || table.commonNames().empty()) {
    app.footer(table.notes());
    return withoutDoubleBlankLines(app.help("", CLI::AppFormatMode::All));
  }
  // options of the empty group are not shown
  for (CLI::Option* option : options) option->group(isCommon(*option, table.commonNames()) ? "Options" : "");
  app.footer(fmt::format("{} --help-all: all {} options.", app.get_name(), options.size()));
  return withoutDoubleBlankLines(app.help());
}

}  // namespace nlg
