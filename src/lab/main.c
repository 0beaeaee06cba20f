/* SPDX-License-Identifier: MIT */
/* main.c - the program isoshade-lab. */
#include <stddef.h>

#include "cli/program.h"
#include "lab/lab.h"

#define ISO_LAB_EXTERN(name) extern const iso_command iso_lab_##name;
ISO_LAB_LIST(ISO_LAB_EXTERN)
#undef ISO_LAB_EXTERN

#define ISO_LAB_ENTRY(name) &iso_lab_##name,
static const iso_command *const commands[] = {ISO_LAB_LIST(ISO_LAB_ENTRY) NULL};
#undef ISO_LAB_ENTRY

int main(int argc, const char **argv)
{
    const iso_program lab = {
        .name = "isoshade-lab",
        .title = "reproduces the papers' tables and figures, and the experiments of doc/results",
        .commands = commands,
    };
    return iso_program_main(&lab, argc, argv);
}
