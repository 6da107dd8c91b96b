// The command nlg-view --watch: bakes a level again whenever its files are saved, and updates the open page through a server
// on this machine.
//
// Each step is an ordinary run of nlg-bake or nlg-view, as a process of its own: a save in the middle ends it, and begins anew; a level
// that cannot be read ends in its error, which the page shows, and the next save is waited for. Outputs are whole or not there, whatever
// ends.
#pragma once

#include <optional>

#include "tool/command/options.h"
#include "viewer/page_server.h"
#include "viewer/view_run.h"

namespace nlg {

// A bake of several that lead to a grid: what nlg-bake is told behind the scene's name.
struct GridBake {
  std::vector<std::string> words;
  std::string grid;  // that it writes
  std::string name;  // "preview"
};

// How a grid is baked again, the last of the bakes the one that is kept; none where it is what would be baked. The one place that decides:
// where light alone has changed functions stay; else the preview is a draft where the weights can draft. Where they cannot, its functions are
// the last bake's too.
//
// can_draft whether the weights read samples
// changes   what `nlg-bake --check` says has changed; nothing: of no grid, or of one that cannot be read
// grid      the file that is kept; preview: one for the bakes before
std::vector<GridBake> bakesAgain(const std::optional<std::vector<std::string>>& changes, const std::string& grid,
                                 const std::string& preview, const BakeOptions& options, bool can_draft);

// The stage that a tool with NLG_PROGRESS=json is at, by what it has said so far; nothing before it has said any.
std::optional<Stage> stageOf(const std::string& said);
// The same without lines of progress.
std::string withoutProgress(const std::string& said);

// Runs until Ctrl-C (SIGINT) or SIGTERM.
// request   grid: the file that is kept up to date; none: grid.safetensors in the page's folder
// table     of the bake's options
// throws    UsageError, OutputError
void watchScene(ViewRequest request, const BakeOptions& options, const OptionTable& table);

}  // namespace nlg
