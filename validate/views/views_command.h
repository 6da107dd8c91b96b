// nlg-validate views: pictures of a scene by every method, against ground truth.
#pragma once

namespace nlg {

int viewsMain(int argc, char** argv);

}  // namespace nlg
