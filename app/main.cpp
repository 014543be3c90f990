#include <CLI/CLI.hpp>

int main(int argc, char** argv) {
  CLI::App app{"Headway: vision, mapping and walking for a humanoid robot"};
  CLI11_PARSE(app, argc, argv);
  return 0;
}
