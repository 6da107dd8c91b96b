// nlg-export without libtorch: what engines and artists need of it. It is what is installed, and all that a build without training has.

#include <CLI/CLI.hpp>
#include <string>

#include "export/commands.h"
#include "tool/command/tool_main.h"

int main(int argc, char** argv) {
  if (const std::optional<int> status = nlg::runCommand(argc, argv)) return *status;
  CLI::App app{"Writes light grids as files for shaders and engines.\n" + std::string(nlg::kCommands) +
                   "\nTo export checkpoints, build with training.",
               "nlg-export"};
  nlg::OptionTable table("export");
  return nlg::runTool(argc, argv, app, table, [] { throw nlg::UsageError("command", "one of --help", "none"); });
}
