#include "app/commands.h"
#include "app/standard_streams.h"

int main(int argc, char** argv) {
  headway::app::fill_standard_streams();
  return headway::app::run_program(argc, argv);
}
