// Writes rows of frames into a folder: what the fuzzer begins with.
#include "tests/fuzz/frame_bytes.h"
#include "tests/fuzz/write_inputs.h"

int main(int argc, char** argv) {
  return headway::fuzz::write_inputs(argc, argv, "frame", headway::fuzz::whole_frame_rows());
}
