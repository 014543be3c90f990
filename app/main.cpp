#include "app/commands.h"

int main(int argc, char** argv) { return headway::app::run_program(argc, argv); }
