// The command `nlg-export engine`: writes a light grid as files that engines load.
#pragma once

namespace nlg {

// nlg-export engine --grid GRID --format FORMAT --out FOLDER
int engineMain(int argc, char** argv);

}  // namespace nlg
