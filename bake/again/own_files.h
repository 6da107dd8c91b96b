// Recognises files of nlg-bake and nlg-view of any version, which these tools may overwrite (tool/output_path.h).
#pragma once

#include "tool/output_path.h"

namespace nlg {

extern const OwnFiles kGridFiles, kReportFiles;

}  // namespace nlg
