#include "tool/command/tool_main.h"

#include <sys/prctl.h>
#include <unistd.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <new>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tool/atomic_file.h"
#include "tool/input_file.h"
#include "tool/output_path.h"
#include "tool/printable.h"
#include "tool/provenance.h"

namespace nlg {
namespace {

// What --help and --help-all print: the options that a user needs first, and all of them by groups.

enum class HelpExtent { common, all };

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

// Adds --help and --help-all to app. Without this it has CLI11's own --help.
void addHelpFlags(CLI::App& app) {
  app.set_help_flag("--help,-h", "print the main options");
  app.set_help_all_flag("--help-all", "print all options");
}

// The text. Lines are broken at 100 columns. app and its options are changed on the way: it is of no use afterwards.
// table   says which options are common (OptionTable::common)
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

// In place of a command line: the table as JSON, for workflow/settings.py.
constexpr const char* kListOptions = "--list-options";
// Likewise: all flags, one a line, for completions.
constexpr const char* kListFlags = "--list-flags";

void listFlags(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) std::cout << "--" << name << '\n';
  }
}

std::string toolName(const CLI::App& app, int argc, char** argv) {
  if (!app.get_name().empty()) return app.get_name();
  return argc > 0 ? std::filesystem::path(argv[0]).filename().string() : "nlg";
}

// What a level or a shard calls itself must not steer the terminal that it is printed on. Of stdout only where that is one: else it
// is for programs, which get every byte.
class PrintableStreams {
 public:
  PrintableStreams() : cout_(std::cout.rdbuf()), cerr_(std::cerr.rdbuf()), to_cout_(cout_), to_cerr_(cerr_) {
    std::cerr.rdbuf(&to_cerr_);
    if (::isatty(STDOUT_FILENO) == 1) std::cout.rdbuf(&to_cout_);
  }
  ~PrintableStreams() {
    std::cout.rdbuf(cout_);
    std::cerr.rdbuf(cerr_);
  }
  PrintableStreams(const PrintableStreams&) = delete;
  PrintableStreams& operator=(const PrintableStreams&) = delete;

 private:
  std::streambuf *const cout_, *const cerr_;
  PrintableBuffer to_cout_, to_cerr_;
};

constexpr size_t kLongestError = 4000;  // bytes: a path and what is said of it; a hostile file's texts have megabytes

// Scripts read stderr by lines: one error, one line.
int fail(const std::string& name, std::string line, ExitCode code) {
  while (!line.empty() && line.back() == '\n') line.pop_back();
  std::cout.flush();
  const size_t left_out = line.size() - std::min(line.size(), kLongestError);
  line.resize(line.size() - left_out);
  const std::string end = left_out > 0 ? fmt::format(" … and {} bytes more", left_out) : std::string();
  std::cerr << name << ": error: " << printable(line) << end << std::endl;
  return static_cast<int>(code);
}

// CLI11 would take the next argument as the value of "--flag=", or call a switch true.
void refuseEmptyAssignments(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--") return;
    if (argument.rfind("--", 0) == 0 && argument.find('=') == argument.size() - 1) {
      throw UsageError(argument.substr(0, argument.size() - 1), "a value after '='", "nothing");
    }
  }
}

// Names of scenes and files travel in JSON and in shards, which hold UTF-8 and nothing else.
void refuseOtherBytes(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    try {
      static_cast<void>(nlohmann::json(argv[i]).dump());
    } catch (const nlohmann::json::type_error&) {
      throw UsageError("argument " + std::to_string(i), "UTF-8", "other bytes");
    }
  }
}

// What a tool prints on stdout is its result: losing it on a full disk or a closed pipe must not look like success.
void flushStandardOutput() {
  std::cout.flush();
  if (!std::cout) throw OutputError("standard output", "disk full or pipe closed");
}

// An option's name without its value, and what stands before a "=".
std::string nameOf(const std::string& argument) { return argument.substr(0, argument.find('=')); }

// CLI11 itself would list them the last one first.
void refuseExtras(const CLI::App& app) {
  std::vector<std::string> extras = app.remaining();
  // it keeps the mark behind which everything is a name
  extras.erase(std::remove(extras.begin(), extras.end(), "--"), extras.end());
  if (extras.empty()) return;
  if (extras[0].find('-') != 0) {
    const bool is_number = extras[0].find_first_not_of("0123456789.,+-e") == std::string::npos;
    throw UsageError(
        "command line", "options and their values",
        "'" + extras[0] + "'" +
            (is_number ? ", which belongs to no option; write a list of numbers with commas and without blanks" : ""));
  }
  std::vector<std::string> known;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  const std::optional<std::string> meant = nearestName(nameOf(extras[0]), known);
  throw UsageError("command line", "an option of --help-all",
                   "'" + nameOf(extras[0]) + "'" + (meant ? "; did you mean " + *meant + "?" : ""));
}

void parseAndRun(int argc, char** argv, CLI::App& app, OptionTable& table, const std::function<void()>& run) {
  std::string config;
  const CLI::Option* config_flag =
      app.add_option("--config", config, "configuration file, such as pipeline.yaml; this tool reads its own section")
          ->type_name("FILE");
  if (app.get_version_ptr() == nullptr) app.set_version_flag("--version", std::string(sourceRevision()));
  addHelpFlags(app);
  table.addFlags(app);
  // before the command line is parsed, which would ask for required options
  if (argc == 2 && std::strcmp(argv[1], kListOptions) == 0) {
    std::cout << table.describeAsJson().dump() << '\n';
    return flushStandardOutput();
  }
  if (argc == 2 && std::strcmp(argv[1], kListFlags) == 0) {
    listFlags(app);
    return flushStandardOutput();
  }
  refuseOtherBytes(argc, argv);
  refuseEmptyAssignments(argc, argv);
  app.allow_extras();
  app.parse(argc, argv);
  refuseExtras(app);
  // the file first, and flags over it
  if (config_flag->count() > 0) table.readYaml(config);
  table.applyFlags();
  const char* const inputs = std::getenv("NLG_INPUTS");
  if (inputs != nullptr) refuseToReplaceOthers(inputs, kInputsFiles, "NLG_INPUTS");
  run();
  flushStandardOutput();
  if (inputs != nullptr) writeFileAtomically(inputs, inputsText(inputsSoFar()));
}

// --help and --version reach us as exceptions too.
int endOfParsing(CLI::App& app, const OptionTable& table, const CLI::ParseError& error, const std::string& name) {
  if (error.get_exit_code() != 0) return fail(name, std::string(error.what()) + "; see --help", ExitCode::usage_error);
  if (error.get_name() == "CallForHelp") {
    std::cout << helpText(app, table, HelpExtent::common);
  } else if (error.get_name() == "CallForAllHelp") {
    std::cout << helpText(app, table, HelpExtent::all);
  } else {
    app.exit(error, std::cout, std::cerr);
  }
  flushStandardOutput();
  return static_cast<int>(ExitCode::success);
}

void endWithParent() {
  const char* const parent = std::getenv(kEndsWith);
  if (parent == nullptr) return;
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  // gone before that
  if (parent != std::to_string(::getppid())) std::raise(SIGTERM);
  ::unsetenv(kEndsWith);
}

}  // namespace

int runTool(int argc, char** argv, CLI::App& app, OptionTable& table, const std::function<void()>& run) {
  const PrintableStreams streams;
  // a closed pipe is an error of writing, not a signal
  std::signal(SIGPIPE, SIG_IGN);
  // past a limit on file sizes write fails with an error, as on a full disk
  std::signal(SIGXFSZ, SIG_IGN);
  removeTemporariesOnSignals();
  endWithParent();
  const std::string name = toolName(app, argc, argv);
  try {
    try {
      parseAndRun(argc, argv, app, table, run);
    } catch (const CLI::ParseError& error) {
      return endOfParsing(app, table, error, name);
    }
  } catch (const ToolError& error) {
    return fail(name, error.what(), error.exitCode());
  } catch (const std::bad_alloc&) {
    return fail(name, "out of memory", ExitCode::internal_error);
  } catch (const std::exception& error) {
    return fail(name, error.what(), ExitCode::internal_error);
  } catch (...) {
    return fail(name, "unknown exception", ExitCode::internal_error);
  }
  return static_cast<int>(ExitCode::success);
}

std::optional<int> runCommand(int argc, char** argv, std::span<const Command> commands) {
  for (const Command& command : commands) {
    if (argc > 1 && std::strcmp(argv[1], command.name) == 0) return command.run(argc - 1, argv + 1);
  }
  return std::nullopt;
}

}  // namespace nlg
