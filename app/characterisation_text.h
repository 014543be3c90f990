// What characterise prints.
#pragma once

#include "app/characterisation.h"

namespace headway::app {

/// To stdout: the rig, its field, its sight over depth and the tours of the head.
void print_characterisation(const Characterisation& characterisation);

}  // namespace headway::app
