/* SPDX-License-Identifier: MIT */
/* child_main.cc - the main() of the programs that read volumes for isoshade: each is this and one child_program. */
#include "volume/child_writer.h"

int main(int argc, char **argv)
{
    return run_child(child_program, argc, argv);
}
