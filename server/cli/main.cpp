#include "server/cli/program.hpp"

int main(int argc, char** argv) { return tetfront::run_program(argc, argv); }
