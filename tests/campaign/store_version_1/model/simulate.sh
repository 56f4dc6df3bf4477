#!/bin/sh
awk -v friction="$1" -v seed="$2" 'BEGIN {
    printf "{\"angle\": %.15g}\n", 10 + 50 * friction * friction + (seed % 1009) / 1009 - 0.5
}' > responses.json
