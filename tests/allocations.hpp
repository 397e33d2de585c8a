#pragma once

/// How often this program has asked for memory so far, by malloc, calloc, realloc or operator new.
/// Always 0 under a sanitizer, which keeps these calls to itself.
long allocations();
