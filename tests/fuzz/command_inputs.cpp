// Writes lines of an operator into a folder: what the fuzzer begins with.
#include "tests/fuzz/command_bytes.h"
#include "tests/fuzz/write_inputs.h"

int main(int argc, char** argv) {
  return headway::fuzz::write_inputs(argc, argv, "command", headway::fuzz::whole_commands());
}
