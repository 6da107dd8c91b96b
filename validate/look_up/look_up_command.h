// nlg-validate look-up: what a viewer sees of a level's light grid, at random places in its air.
#pragma once

namespace nlg {

int lookUpMain(int argc, char** argv);

}  // namespace nlg
