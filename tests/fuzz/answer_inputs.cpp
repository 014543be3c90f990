// Writes conversations with the head's drives into a folder: what the fuzzer begins with.
#include "tests/fuzz/answer_bytes.h"
#include "tests/fuzz/write_inputs.h"

int main(int argc, char** argv) {
  return headway::fuzz::write_inputs(argc, argv, "answer", headway::fuzz::whole_answers());
}
