// Writes small recordings into a folder: what the fuzzer begins with.
#include "tests/fuzz/recording_bytes.h"
#include "tests/fuzz/write_inputs.h"

int main(int argc, char** argv) {
  return headway::fuzz::write_inputs(argc, argv, "recording", headway::fuzz::whole_recordings());
}
